// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/policy_io.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/json_text.hpp"
#include "tasks/relocate/policies/policy_record.hpp"

namespace palpate::relocate {
namespace {

using nlohmann::json;
using recording::shown;

constexpr const char* kFormat = "palpate-policy";
constexpr int kPolicyVersion = 1;
constexpr double kDexMvScaleFloor = 1e-8;  // that DexMV adds to the scale of the inputs

std::vector<double> numbers(const json& value, const std::string& name) {
  if (!value.is_array()) throw BadInput(fmt::format("'{}' is no list of numbers", name));
  std::vector<double> result;
  for (const auto& item : value) {
    if (!item.is_number() || !std::isfinite(item.get<double>())) {
      throw BadInput(fmt::format("'{}' holds {}, which is no finite number", name, shown(item)));
    }
    result.push_back(item.get<double>());
  }
  return result;
}

const json& member(const json& object, const char* name) {
  if (!object.contains(name)) throw BadInput(fmt::format("'{}' is missing", name));
  return object[name];
}

std::string text(const json& object, const char* name) {
  const json& value = member(object, name);
  if (!value.is_string()) throw BadInput(fmt::format("'{}' is {}, no text", name, shown(value)));
  return value.get<std::string>();
}

void check_keys(const json& object, const std::vector<std::string>& known) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      throw BadInput(fmt::format("'{}' is an unknown key", key));
    }
  }
}

std::map<std::string, std::string> notes_of(const json& file) {
  std::map<std::string, std::string> notes;
  const json& object = member(file, "notes");
  if (!object.is_object()) throw BadInput("'notes' is no object");
  for (const auto& [key, value] : object.items()) notes[key] = text(object, key.c_str());
  return notes;
}

PolicyRecord read_own(const json& file) {
  check_keys(file, {"format", "version", "task", "kind", "sizes", "arrays", "notes"});
  if (text(file, "format") != kFormat) {
    throw BadInput(fmt::format("of format {}, not \"{}\"", shown(file["format"]), kFormat));
  }
  if (member(file, "version") != kPolicyVersion) {
    throw BadInput(fmt::format("of version {}, not {}", shown(file["version"]), kPolicyVersion));
  }
  const std::string task = text(file, "task");
  if (task != kRelocateVersion && task != kFormerRelocateVersion) {
    throw BadInput(
        fmt::format("for the task {}, not \"{}\"", shown(file["task"]), kRelocateVersion));
  }
  PolicyRecord record;
  record.kind = text(file, "kind");
  const auto sizes = numbers(member(file, "sizes"), "sizes");
  record.sizes = layer_sizes(Eigen::VectorXd::Map(sizes.data(), std::ssize(sizes)));
  const json& arrays = member(file, "arrays");
  if (!arrays.is_object()) throw BadInput("'arrays' is no object");
  for (const auto& [name, values] : arrays.items()) record.arrays[name] = numbers(values, name);
  record.notes = notes_of(file);
  return record;
}

/// Appends a matrix that the file holds row by row, column by column.
void append_weights(const json& rows, const std::string& name, std::vector<double>& parameters) {
  std::vector<std::vector<double>> values;
  if (!rows.is_array() || rows.empty()) throw BadInput(fmt::format("'{}' is no matrix", name));
  for (const auto& row : rows) values.push_back(numbers(row, name));
  for (const auto& row : values) {
    if (row.empty() || row.size() != values.front().size()) {
      throw BadInput(fmt::format("'{}' has rows of {} and {} values", name, values.front().size(),
                                 row.size()));
    }
  }
  for (std::size_t column = 0; column < values.front().size(); ++column) {
    for (const auto& row : values) parameters.push_back(row[column]);
  }
}

/// @param inputs  as many values as the layer gets; -1: any
void check_layer(const json& rows, const std::string& weights, int inputs, std::size_t biases) {
  const std::size_t outputs = rows.size(), columns = rows.front().size();
  if (inputs >= 0 && std::cmp_not_equal(columns, inputs)) {
    throw BadInput(fmt::format("'{}' is {} x {}, behind a layer of {} units", weights, outputs,
                               columns, inputs));
  }
  if (biases == outputs) return;
  throw BadInput(fmt::format("'{}' is {} x {}, with {} biases", weights, outputs, columns, biases));
}

PolicyRecord read_dexmv(const json& file) {
  constexpr std::array<std::array<const char*, 2>, 3> kLayers = {
      {{"W0", "b0"}, {"W1", "b1"}, {"W2", "b2"}}};
  PolicyRecord record;
  record.kind = "mlp";
  auto& parameters = record.arrays["parameters"];
  for (const auto& [weights, biases] : kLayers) {
    const json& rows = member(file, weights);
    append_weights(rows, weights, parameters);
    const auto b = numbers(member(file, biases), biases);
    check_layer(rows, weights, record.sizes.empty() ? -1 : record.sizes.back(), b.size());
    if (record.sizes.empty()) record.sizes.push_back(static_cast<int>(rows.front().size()));
    record.sizes.push_back(static_cast<int>(rows.size()));
    parameters.insert(parameters.end(), b.begin(), b.end());
  }
  record.arrays["input_shift"] = numbers(member(file, "in_shift"), "in_shift");
  record.arrays["input_scale"] = numbers(member(file, "in_scale"), "in_scale");
  for (double& scale : record.arrays["input_scale"]) scale += kDexMvScaleFloor;
  record.arrays["output_shift"] = numbers(member(file, "out_shift"), "out_shift");
  record.arrays["output_scale"] = numbers(member(file, "out_scale"), "out_scale");
  record.arrays["log_std"] = numbers(member(file, "log_std"), "log_std");
  return record;
}

}  // namespace

void save_policy(const std::filesystem::path& path, const PolicyRecord& record) {
  const json file = {{"format", kFormat},        {"version", kPolicyVersion},
                     {"task", kRelocateVersion}, {"kind", record.kind},
                     {"sizes", record.sizes},    {"arrays", record.arrays},
                     {"notes", record.notes}};
  write_file_atomically(path, file.dump() + "\n");
}

PolicyRecord read_policy(const std::filesystem::path& path) {
  const std::string content = read_file(path);
  try {
    const json file = recording::parse_json(content);
    if (!file.is_object()) throw BadInput("no policy file: not a JSON object");
    return file.contains("W0") ? read_dexmv(file) : read_own(file);
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", path.string(), error.what()));
  }
}

std::unique_ptr<Policy> load_policy(const std::filesystem::path& path) {
  const PolicyRecord record = read_policy(path);
  try {
    return policy_from(record);
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace palpate::relocate
