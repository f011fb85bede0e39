// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "train_arguments.hpp"
#include "train_curves.hpp"

namespace palpate::app {

/// The folder of a training, locked. Without --force a folder with a checkpoint is left as it is,
/// for the training goes on if its settings are the same.
/// @return none for a share of another's training, which has no result
/// @throws BadInput as OutputFolder does, and if --force would remove a policy to start from
std::unique_ptr<OutputFolder> claim_training(const TrainArguments& arguments);

/// What a training keeps: the checkpoint of its last iteration, the policy and the curves so far.
///
/// A checkpoint is the first file of a training and the last of each iteration: whoever is killed
/// leaves a folder from which the same command goes on.
class TrainingFolder {
 public:
  /// @param settings  what identifies the training
  TrainingFolder(const TrainArguments& arguments, std::string settings);

  const std::filesystem::path& path() const { return path_; }

  /// Goes on from the checkpoint. @return whether there is one
  /// @throws BadInput if it is of other settings
  bool resume(relocate::Trainer& trainer);

  void keep_checkpoint(const relocate::Trainer& trainer) const;
  void write_policy(const relocate::Trainer& trainer) const;
  /// Keeps all that an iteration has brought.
  void keep_iteration(const relocate::Trainer& trainer, const relocate::Metrics& metrics);

 private:
  const TrainArguments& arguments_;
  std::string settings_;
  std::filesystem::path path_;
  Curves curves_;
};

}  // namespace palpate::app
