// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/minari_io.hpp"

#include <H5Cpp.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "palpate/core/durable_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/hdf5_guard.hpp"
#include "palpate/recording/json_text.hpp"

namespace palpate::relocate {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using nlohmann::json;

constexpr const char* kMinariVersion = "0.5.1";
constexpr const char* kIntended = "intended";  // info: the actions before noise was added
constexpr hsize_t kChunk = 64;                 // rows
constexpr hsize_t kMaxValues = 1ULL << 31;     // of one table
constexpr std::uintmax_t kMaxUnpacked = 8;     // values in all, for each byte of the file
constexpr std::size_t kMaxValueBytes = 16;     // of a number

std::string name_of(std::size_t episode) { return fmt::format("episode_{}", episode); }

void check(const MinariEpisode& e, std::size_t number) {
  const Index steps = e.actions.cols();
  if (steps == 0) throw BadInput(fmt::format("{} has no steps", name_of(number)));
  if (e.observations.cols() != steps + 1 || e.rewards.size() != steps) {
    throw BadInput(fmt::format("{} has {} observations and {} rewards of {} actions",
                               name_of(number), e.observations.cols(), e.rewards.size(), steps));
  }
  if (!e.observations.allFinite() || !e.actions.allFinite()) {
    throw BadInput(fmt::format("{} holds a value that is not finite", name_of(number)));
  }
  for (const auto& [name, values] : e.infos) {
    if (values.cols() == steps + 1 && values.allFinite()) continue;
    throw BadInput(fmt::format("{}: info '{}' is not {} columns of finite values", name_of(number),
                               name, steps + 1));
  }
  for (Index t = 0; t < steps; ++t) {
    if (!std::isfinite(e.rewards[t])) {
      throw BadInput(fmt::format("{}: reward {} is {}", name_of(number), t, e.rewards[t]));
    }
  }
}

void check(const MinariDataset& dataset) {
  if (dataset.episodes.empty()) throw BadInput("a dataset without episodes");
  const MinariEpisode& first = dataset.episodes.front();
  for (std::size_t i = 0; i < dataset.episodes.size(); ++i) {
    const MinariEpisode& e = dataset.episodes[i];
    check(e, i);
    if (e.observations.rows() != first.observations.rows() ||
        e.actions.rows() != first.actions.rows()) {
      throw BadInput(
          fmt::format("{} has {} observations and {} actions a step, the first {} and {}",
                      name_of(i), e.observations.rows(), e.actions.rows(),
                      first.observations.rows(), first.actions.rows()));
    }
  }
}

H5::EnumType boolean() {
  H5::EnumType type(H5::PredType::NATIVE_INT8);
  std::int8_t value = 0;
  type.insert("FALSE", &value);
  value = 1;
  type.insert("TRUE", &value);
  return type;
}

/// A chunked dataset that could grow by rows, as Minari makes them. @param width  0: a plain vector
void write_table(H5::Group& group, const char* name, const void* values, hsize_t rows,
                 hsize_t width, const H5::DataType& type) {
  const int rank = width > 0 ? 2 : 1;
  const std::array<hsize_t, 2> size = {rows, width}, most = {H5S_UNLIMITED, width},
                               chunk = {std::min(rows, kChunk), width};
  H5::DSetCreatPropList properties;
  properties.setChunk(rank, chunk.data());
  group.createDataSet(name, type, H5::DataSpace(rank, size.data(), most.data()), properties)
      .write(values, type);
}

void write_attribute(H5::Group& group, const char* name, std::uint64_t value) {
  const auto stored = static_cast<std::int64_t>(value);
  group.createAttribute(name, H5::PredType::NATIVE_INT64, H5::DataSpace())
      .write(H5::PredType::NATIVE_INT64, &stored);
}

void write_episode(H5::H5File& file, const MinariEpisode& e, std::size_t number) {
  H5::Group group = file.createGroup(name_of(number));
  const auto steps = static_cast<hsize_t>(e.actions.cols());
  write_attribute(group, "id", number);
  write_attribute(group, "total_steps", steps);
  write_attribute(group, "seed", e.seed);
  const auto& number_type = H5::PredType::NATIVE_DOUBLE;
  // A column of an Eigen matrix is a row of the table.
  write_table(group, "observations", e.observations.data(), steps + 1,
              static_cast<hsize_t>(e.observations.rows()), number_type);
  write_table(group, "actions", e.actions.data(), steps, static_cast<hsize_t>(e.actions.rows()),
              number_type);
  write_table(group, "rewards", e.rewards.data(), steps, 0, number_type);
  std::vector<std::int8_t> ended(steps, 0), cut(steps, 0);
  (e.terminated ? ended : cut).back() = 1;
  write_table(group, "terminations", ended.data(), steps, 0, boolean());
  write_table(group, "truncations", cut.data(), steps, 0, boolean());
  H5::Group infos = group.createGroup("infos");
  for (const auto& [name, values] : e.infos) {
    write_table(infos, name.c_str(), values.data(), steps + 1, static_cast<hsize_t>(values.rows()),
                number_type);
  }
}

json box(Index size, const json& low, const json& high) {
  return {{"type", "Box"},
          {"dtype", "float64"},
          {"shape", {size}},
          {"low", std::vector<json>(static_cast<std::size_t>(size), low)},
          {"high", std::vector<json>(static_cast<std::size_t>(size), high)}};
}

/// JSON has no infinity; Minari reads Python's.
std::string endless_box(Index size) {
  std::string text = box(size, "-Infinity", "Infinity").dump();
  for (const char* word : {"\"-Infinity\"", "\"Infinity\""}) {
    const std::string quoted = word, bare = quoted.substr(1, quoted.size() - 2);
    for (std::size_t at = 0; (at = text.find(quoted, at)) != std::string::npos;) {
      text.replace(at, quoted.size(), bare);
    }
  }
  return text;
}

json metadata(const MinariDataset& dataset) {
  std::uint64_t steps = 0;
  for (const auto& e : dataset.episodes) steps += static_cast<std::uint64_t>(e.actions.cols());
  const MinariEpisode& first = dataset.episodes.front();
  json head = {{"total_episodes", dataset.episodes.size()},
               {"total_steps", steps},
               {"data_format", "hdf5"},
               {"dataset_id", dataset.id},
               {"minari_version", kMinariVersion},
               {"observation_space", endless_box(first.observations.rows())},
               {"action_space", box(first.actions.rows(), -1.0, 1.0).dump()}};
  if (!dataset.env_spec.empty()) head["env_spec"] = dataset.env_spec;
  return head;
}

/// How many values are still read of a file.
struct Room {
  std::uintmax_t of_table, left;
};

/// A table of numbers as a matrix of `rank` 2 (width x rows) or a column (rows x 1) of rank 1.
MatrixXd read_table(const H5::Group& group, const char* name, int rank, Room& room) {
  const H5::DataSet table = group.openDataSet(name);
  const H5::DataSpace space = table.getSpace();
  std::array<hsize_t, 2> size = {0, 1};
  if (space.getSimpleExtentNdims() != rank) {
    throw BadInput(
        fmt::format("'{}' has {} dimensions, not {}", name, space.getSimpleExtentNdims(), rank));
  }
  space.getSimpleExtentDims(size.data());
  const auto kind = table.getTypeClass();
  if (kind != H5T_FLOAT && kind != H5T_INTEGER && kind != H5T_ENUM) {
    throw BadInput(fmt::format("'{}' holds no numbers", name));
  }
  // HDF5 sorts the values of an enumeration in a buffer of 32 bytes, whatever their size.
  const std::size_t value_bytes = table.getDataType().getSize();
  if (value_bytes > (kind == H5T_ENUM ? sizeof(std::int8_t) : kMaxValueBytes)) {
    throw BadInput(fmt::format("'{}' has values of {} bytes", name, value_bytes));
  }
  const hsize_t most = std::min<hsize_t>({kMaxValues, room.of_table, room.left});
  if (size[1] > 0 && size[0] > most / size[1]) {
    throw BadInput(fmt::format("'{}' claims {} x {} values, more than the file holds", name,
                               size[0], size[1]));
  }
  room.left -= size[0] * size[1];
  MatrixXd values(static_cast<Index>(rank == 2 ? size[1] : size[0]),
                  static_cast<Index>(rank == 2 ? size[0] : 1));
  if (kind == H5T_ENUM) {
    std::vector<std::int8_t> raw(size[0] * size[1]);
    table.read(raw.data(), boolean());
    values.reshaped() = Eigen::Map<const Eigen::Vector<std::int8_t, Eigen::Dynamic>>(
                            raw.data(), static_cast<Index>(raw.size()))
                            .cast<double>();
  } else {
    table.read(values.data(), H5::PredType::NATIVE_DOUBLE);
  }
  return values;
}

std::uint64_t read_seed(const H5::Group& group) {
  if (!group.attrExists("seed")) return 0;
  const H5::Attribute attribute = group.openAttribute("seed");
  if (attribute.getTypeClass() != H5T_INTEGER) return 0;
  if (const std::size_t bytes = attribute.getDataType().getSize(); bytes > kMaxValueBytes) {
    throw BadInput(fmt::format("the attribute 'seed' has {} bytes", bytes));
  }
  if (const auto count = attribute.getSpace().getSimpleExtentNpoints(); count != 1) {
    throw BadInput(fmt::format("the attribute 'seed' has {} values, not 1", count));
  }
  std::int64_t value = 0;
  attribute.read(H5::PredType::NATIVE_INT64, &value);
  return static_cast<std::uint64_t>(value);
}

MinariEpisode read_episode(const H5::H5File& file, std::size_t number, Room& room) {
  const H5::Group group = file.openGroup(name_of(number));
  MinariEpisode e;
  e.observations = read_table(group, "observations", 2, room);
  e.actions = read_table(group, "actions", 2, room);
  e.rewards = read_table(group, "rewards", 1, room);
  const MatrixXd ended = read_table(group, "terminations", 1, room);
  e.terminated = ended.size() > 0 && ended(ended.size() - 1) != 0;
  e.seed = read_seed(group);
  if (!group.nameExists("infos")) return e;
  const H5::Group infos = group.openGroup("infos");
  if (infos.nameExists(kIntended)) e.infos[kIntended] = read_table(infos, kIntended, 2, room);
  return e;
}

/// The text of that name, none if there is nothing or something else.
std::string text_of(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

json read_metadata(const std::filesystem::path& path) {
  const json head = [&] {
    try {
      return recording::parse_json(read_file(path));
    } catch (const BadInput& error) {
      throw BadInput(fmt::format("{}: not the metadata of a Minari dataset in HDF5 ({})",
                                 path.string(), error.what()));
    }
  }();
  const auto count = head.find("total_episodes");
  if (!head.is_object() || count == head.end() || !count->is_number_unsigned() ||
      text_of(head, "data_format") != "hdf5") {
    throw BadInput(fmt::format("{}: not the metadata of a Minari dataset in HDF5", path.string()));
  }
  if (const auto id = head.find("dataset_id"); id != head.end() && !id->is_string()) {
    throw BadInput(
        fmt::format("{}: 'dataset_id' is {}, no text", path.string(), recording::shown(*id)));
  }
  return head;
}

}  // namespace

void write_minari(const std::filesystem::path& folder, const MinariDataset& dataset) {
  check(dataset);
  const auto data = folder / "data";
  make_writable_folder(data);
  const auto path = data / "main_data.hdf5", partial = data / "main_data.hdf5.partial";
  recording::with_hdf5(partial, "cannot be written", [&] {
    H5::H5File file(partial.string(), H5F_ACC_TRUNC);
    for (std::size_t i = 0; i < dataset.episodes.size(); ++i) {
      write_episode(file, dataset.episodes[i], i);
    }
  });
  // Without metadata there is no data set, where this ends between the two files.
  std::filesystem::remove(data / "metadata.json");
  publish_file(partial, path);
  write_file_atomically(data / "metadata.json", metadata(dataset).dump(2) + "\n");
}

MinariDataset read_minari(const std::filesystem::path& folder) {
  const json head = read_metadata(folder / "data/metadata.json");
  const auto path = folder / "data/main_data.hdf5";
  if (!std::filesystem::exists(path)) {
    throw BadInput(fmt::format("{}: there is no such file", path.string()));
  }
  MinariDataset dataset;
  dataset.id = text_of(head, "dataset_id");
  const auto count = head["total_episodes"].get<std::size_t>();
  recording::with_hdf5(path, "no Minari dataset, or damaged", [&] {
    const H5::H5File file(path.string(), H5F_ACC_RDONLY);
    try {
      const auto bytes = static_cast<std::uintmax_t>(file.getFileSize());
      Room room{bytes, kMaxUnpacked * bytes};
      for (std::size_t i = 0; i < count; ++i) {
        dataset.episodes.push_back(read_episode(file, i, room));
      }
      check(dataset);
    } catch (const BadInput& error) {
      throw BadInput(fmt::format("{}: {}", path.string(), error.what()));
    }
  });
  return dataset;
}

MinariDataset dataset_of(const std::vector<Demonstration>& demonstrations, const std::string& id,
                         std::uint64_t seed) {
  MinariDataset dataset;
  dataset.id = id;
  for (const auto& d : demonstrations) {
    const Index columns = d.path.observations.cols();
    dataset.episodes.push_back(
        {d.path.observations,
         d.path.actions.cwiseMax(-1).cwiseMin(1),
         d.path.rewards,
         false,
         episode_seed(seed, d.index),
         {{"truth", d.path.positions}, {"target", d.start.target.replicate(1, columns)}}});
    if (d.intended == dataset.episodes.back().actions) continue;
    Eigen::MatrixXd intended(d.intended.rows(), columns);
    intended << d.intended, d.intended.rightCols<1>();
    dataset.episodes.back().infos[kIntended] = std::move(intended);
  }
  return dataset;
}

std::string environment_spec(const TaskOptions& task, const EpisodeOptions& episode) {
  json arguments = {{"flat", true}};
  const auto note = [&](const char* name, const auto& value, const auto&...) {
    arguments[name] = value;
  };
  TaskOptions(task).visit(note);
  EpisodeOptions(episode).visit(note);
  return json{{"id", "Palpate/Relocate-v2"},
              {"entry_point", "palpate.relocate_env:RelocateEnv"},
              {"reward_threshold", nullptr},
              {"nondeterministic", false},
              {"max_episode_steps", nullptr},
              {"order_enforce", true},
              {"disable_env_checker", false},
              {"kwargs", arguments},
              {"additional_wrappers", json::array()},
              {"vector_entry_point", "palpate.relocate_env:RelocateVectorEnv"}}
      .dump();
}

Demonstrations frames_of(const MinariDataset& dataset) {
  Demonstrations frames;
  Index count = 0;
  for (const auto& e : dataset.episodes) count += e.actions.cols();
  frames.observations.resize(kRelocateObservations, count);
  frames.actions.resize(kRelocateJoints, count);
  Index next = 0;
  for (const auto& e : dataset.episodes) {
    if (e.observations.rows() != kRelocateObservations || e.actions.rows() != kRelocateJoints) {
      throw BadInput(fmt::format(
          "a dataset of {} observations and {} actions a step, not {} and {}",
          e.observations.rows(), e.actions.rows(), kRelocateObservations, kRelocateJoints));
    }
    frames.observations.middleCols(next, e.actions.cols()) =
        e.observations.leftCols(e.actions.cols());
    const auto intended = e.infos.find(kIntended);
    const MatrixXd& actions = intended == e.infos.end() ? e.actions : intended->second;
    if (actions.rows() != kRelocateJoints) {
      throw BadInput(fmt::format("info '{}' of {} values a step, not {}", kIntended, actions.rows(),
                                 kRelocateJoints));
    }
    frames.actions.middleCols(next, e.actions.cols()) =
        actions.leftCols(e.actions.cols()).cwiseMax(-1).cwiseMin(1);
    next += e.actions.cols();
  }
  return frames;
}

}  // namespace palpate::relocate
