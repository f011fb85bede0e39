// SPDX-License-Identifier: Apache-2.0
#include "hdf5_targets.hpp"

#include <H5Cpp.h>

#include <array>

#include "grammar.hpp"
#include "mutate.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/recording/hdf5_guard.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/ros2/export_recording.hpp"
#include "palpate/ros2/read_bag.hpp"
#include "palpate/tasks/relocate/minari_io.hpp"
#include "recording/seal.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 12> kTables = {
    "header/json",       "header/vertices",      "header/triangles",
    "frames/time",       "frames/contacts",      "frames/contact_counts",
    "frames/joints",     "frames/base_force",    "frames/true_joints",
    "events/json_lines", "estimates/json_lines", "frames/true_T_world_object"};

constexpr std::array<const char*, 4> kSetTables = {"episode_0/observations", "episode_0/actions",
                                                   "episode_1/observations", "episode_1/actions"};

std::string sample_recording(const fs::path& folder) {
  recording::write_recording(folder / "sample.h5", recording::toy_recording(12));
  return read_file(folder / "sample.h5");
}

/// Rewrites a table of text with a changed one.
void change_text(const H5::DataSet& table, RandomStream& random) {
  hsize_t size[2] = {};
  table.getSpace().getSimpleExtentDims(size);
  std::string text(size[0], ' ');
  table.read(text.data(), H5::PredType::NATIVE_UINT8);
  text = mutated(text, random);
  size[0] = text.size();
  table.extend(size);
  if (!text.empty()) table.write(text.data(), H5::PredType::NATIVE_UINT8);
}

/// Overwrites a value of a table of numbers, or changes how many rows it has.
void change_numbers(const H5::DataSet& table, RandomStream& random) {
  hsize_t size[2] = {};
  table.getSpace().getSimpleExtentDims(size);
  if (random.index(3) == 0 || size[0] == 0) {
    size[0] = random.index(3) == 0 ? 1 << random.index(16) : random.index(2 * size[0] + 2);
    table.extend(size);
    return;
  }
  std::vector<double> values(size[0] * size[1]);
  table.read(values.data(), H5::PredType::NATIVE_DOUBLE);
  constexpr std::array<double, 8> kValues = {0, -1, 1e200, -1e9, 3, 0.5, 1e-300, 2147483647};
  values[random.index(values.size())] =
      random.index(8) == 0 ? std::nan("") : kValues[random.index(kValues.size())];
  table.write(values.data(), H5::PredType::NATIVE_DOUBLE);
}

/// Changes up to two of some tables, through HDF5.
template <std::size_t N>
void change_tables(const fs::path& path, const std::array<const char*, N>& tables,
                   RandomStream& random) {
  try {
    recording::with_hdf5(path, "damaged", [&] {
      H5::H5File file(path.string(), H5F_ACC_RDWR);
      for (std::size_t i = random.index(3); i > 0; --i) {
        const auto table = file.openDataSet(tables[random.index(N)]);
        const bool text = table.getTypeClass() == H5T_INTEGER && table.getIntType().getSize() == 1;
        text ? change_text(table, random) : change_numbers(table, random);
      }
    });
  } catch (const BadInput&) {
  }
}

/// Changes what is in the tables, through HDF5, and seals the file again. Where its bytes were
/// changed so that HDF5 cannot open it, it is only sealed.
void change_and_seal(const fs::path& path, RandomStream& random) {
  change_tables(path, kTables, random);
  recording::write_closed_seal(path, recording::kFormatVersion);
}

std::string sample_dataset(const fs::path& folder) {
  relocate::MinariDataset dataset;
  dataset.id = "toy/v0";
  dataset.episodes.assign(2,
                          {Eigen::MatrixXd::Constant(3, 5, 1), Eigen::MatrixXd::Constant(2, 4, 1),
                           Eigen::VectorXd::Ones(4), false, 1});
  relocate::write_minari(folder / "sample", dataset);
  return read_file(folder / "sample/data/main_data.hdf5");
}

/// The input as the data file of a set, whose metadata are changed now and then, too.
void load_dataset(const fs::path& file) {
  const fs::path folder = file.parent_path() / "set";
  fs::create_directories(folder / "data");
  fs::copy_file(file, folder / "data/main_data.hdf5", fs::copy_options::overwrite_existing);
  if (!fs::exists(folder / "data/metadata.json")) {
    fs::copy_file(file.parent_path() / "sample/data/metadata.json", folder / "data/metadata.json");
  }
  relocate::read_minari(folder);
}

void change_set(const fs::path& file, RandomStream& random) {
  change_tables(file, kSetTables, random);
  const fs::path folder = file.parent_path();
  if (random.index(3) > 0) {
    fs::remove(folder / "set/data/metadata.json");
    return;
  }
  const std::string sample = read_file(folder / "sample/data/metadata.json");
  write_file_atomically(folder / "set/data/metadata.json", mutated(sample, random));
}

/// A bag without chunks, so that no CRC stands before what is in it.
std::string sample_bag(const fs::path& folder) {
  ros2::export_mcap(recording::toy_recording(12), folder / "sample.mcap", {}, 0);
  return read_file(folder / "sample.mcap");
}

void load_bag(const fs::path& file) { ros2::read_bag(file, recording::toy_hand()); }

}  // namespace

std::vector<Target> hdf5_targets() {
  return {
      {"recording", "", "input.h5", [](const fs::path& file) { recording::read_recording(file); },
       sample_recording, change_and_seal},
      {"minari", "", "input.hdf5", load_dataset, sample_dataset, change_set, true},
      {"mcap", "", "input.mcap", load_bag, sample_bag, {}}};
}

}  // namespace palpate::fuzz
