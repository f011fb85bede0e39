// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "palpate/tasks/relocate/demonstration.hpp"

namespace palpate::relocate {

/// One episode, a column a step.
struct MinariEpisode {
  Eigen::MatrixXd observations;  ///< d x (T + 1)
  Eigen::MatrixXd actions;       ///< a x T
  Eigen::VectorXd rewards;       ///< T
  bool terminated = false;       ///< how it ended; otherwise it was cut off
  std::uint64_t seed = 0;        ///< with which the environment starts it again
  /// n x (T + 1) each; of these only "intended" is read: the actions before noise was added
  std::map<std::string, Eigen::MatrixXd> infos = {};
};

/// Episodes as the Minari library keeps them (format of version 0.5, HDF5).
struct MinariDataset {
  std::string id;  ///< as in "palpate/relocate-human-v0"
  std::vector<MinariEpisode> episodes;
  std::string env_spec = {};  ///< of gymnasium, JSON, by which Minari recovers the environment
};

/// Writes FOLDER/data/main_data.hdf5 and FOLDER/data/metadata.json, each atomically. Boxes without
/// limits stand for the space of observations, and -1..1 for that of actions.
/// @throws BadInput for no episode, one without steps, sizes that differ, or a value that is not
///         finite
void write_minari(const std::filesystem::path& folder, const MinariDataset& dataset);

/// Reads what Minari or write_minari wrote. @param folder  the one that holds data/
/// @throws BadInput, naming the file and what is wrong: missing, corrupt, of another format,
/// without
///         episodes, or with an episode that write_minari would refuse
MinariDataset read_minari(const std::filesystem::path& folder);

/// The demonstrations as a dataset, and a dataset's frames to learn from. An episode's seed is its
/// episode_seed(); its infos are those of the Python package's environment: "truth" (37), whose
/// first row is the start, and "target" (3); "intended" (30) where noise was added to the actions.
/// Frames have the intended actions.
/// @throws BadInput for a seed that episode_seed() refuses
MinariDataset dataset_of(const std::vector<Demonstration>& demonstrations, const std::string& id,
                         std::uint64_t seed);

/// gymnasium's spec of the environment Palpate/Relocate-v2 with this task and these episodes.
std::string environment_spec(const TaskOptions& task, const EpisodeOptions& episode);

/// @throws BadInput unless observations and actions have the relocate task's sizes
Demonstrations frames_of(const MinariDataset& dataset);

}  // namespace palpate::relocate
