// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/training/checkpoint.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/json_text.hpp"

namespace palpate::learning {
namespace {

using nlohmann::json;
static_assert(std::endian::native == std::endian::little);

constexpr const char* kFormat = "palpate-checkpoint";
constexpr int kCheckpointVersion = 1;
constexpr Eigen::Index kMaxSide = 100'000'000;  // rows or columns

json header(const Checkpoint& checkpoint) {
  json arrays = json::array();
  for (const auto& [name, values] : checkpoint.arrays) {
    arrays.push_back({{"name", name}, {"rows", values.rows()}, {"cols", values.cols()}});
  }
  return {{"format", kFormat},
          {"version", kCheckpointVersion},
          {"method", checkpoint.method},
          {"seed", checkpoint.seed},
          {"iteration", checkpoint.iteration},
          {"settings", checkpoint.settings},
          {"arrays", arrays}};
}

/// Takes an array's numbers off the front of the bytes.
Eigen::MatrixXd take(std::string_view& bytes, Eigen::Index rows, Eigen::Index cols) {
  if (rows < 0 || cols < 0 || rows > kMaxSide || cols > kMaxSide) {
    throw BadInput(fmt::format("an array of {} x {}", rows, cols));
  }
  const auto size =
      static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols) * sizeof(double);
  if (bytes.size() < size) {
    throw BadInput(fmt::format("{} bytes left for an array of {} x {}", bytes.size(), rows, cols));
  }
  Eigen::MatrixXd values(rows, cols);
  if (size > 0) std::memcpy(values.data(), bytes.data(), size);
  bytes.remove_prefix(size);
  return values;
}

Checkpoint parse(std::string_view bytes) {
  const auto end = bytes.find('\n');
  if (end == std::string_view::npos) throw BadInput("no checkpoint: it has no first line");
  const json head = recording::parse_json(bytes.substr(0, end));
  bytes.remove_prefix(end + 1);
  if (!head.is_object() || head.value("format", "") != kFormat) {
    throw BadInput(fmt::format("no checkpoint: not of format \"{}\"", kFormat));
  }
  if (head.value("version", 0) != kCheckpointVersion) {
    throw BadInput(
        fmt::format("of version {}, not {}", head.value("version", 0), kCheckpointVersion));
  }
  Checkpoint checkpoint;
  checkpoint.method = head.at("method").get<std::string>();
  checkpoint.seed = head.at("seed").get<std::uint64_t>();
  checkpoint.iteration = head.at("iteration").get<int>();
  checkpoint.settings = head.at("settings").get<std::string>();
  for (const json& array : head.at("arrays")) {
    checkpoint.arrays[array.at("name").get<std::string>()] =
        take(bytes, array.at("rows").get<Eigen::Index>(), array.at("cols").get<Eigen::Index>());
  }
  if (!bytes.empty()) throw BadInput(fmt::format("{} bytes too many", bytes.size()));
  return checkpoint;
}

}  // namespace

const Eigen::MatrixXd& Checkpoint::array(const std::string& name) const {
  const auto found = arrays.find(name);
  if (found == arrays.end()) {
    throw BadInput(fmt::format("a checkpoint of {} without '{}'", method, name));
  }
  return found->second;
}

Eigen::VectorXd Checkpoint::column(const std::string& name, Eigen::Index rows) const {
  const Eigen::MatrixXd& values = array(name);
  if (values.cols() != 1 || (rows >= 0 && values.rows() != rows) || !values.allFinite()) {
    throw BadInput(fmt::format("a checkpoint of {} whose '{}' is {} x {}{}", method, name,
                               values.rows(), values.cols(),
                               values.allFinite() ? "" : " with values that are not finite"));
  }
  return values.col(0);
}

void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  std::string bytes = header(checkpoint).dump() + "\n";
  for (const auto& [name, values] : checkpoint.arrays) {
    bytes.append(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::size_t>(values.size()) * sizeof(double));
  }
  write_file_atomically(path, bytes);
}

Checkpoint load_checkpoint(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  try {
    return parse(bytes);
  } catch (const json::exception& error) {
    throw BadInput(fmt::format("{}: no checkpoint: {}", path.string(), error.what()));
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace palpate::learning
