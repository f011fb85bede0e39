// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/temporary_folder.hpp"
#include "core/write_faults.hpp"
#include "palpate/core/file.hpp"
#include "palpate/learning/training/checkpoint.hpp"
#include "palpate/tasks/relocate/minari_io.hpp"

namespace palpate::relocate {
namespace {

namespace fs = std::filesystem;

MinariDataset dataset_of_steps(std::size_t episodes, double value) {
  MinariDataset dataset;
  dataset.id = "toy/v0";
  for (std::size_t i = 0; i < episodes; ++i) {
    dataset.episodes.push_back({Eigen::MatrixXd::Constant(3, 201, value),
                                Eigen::MatrixXd::Constant(2, 200, 0.5),
                                Eigen::VectorXd::Constant(200, 1.0), false, i});
  }
  return dataset;
}

/// What the folder's data set holds: its number of episodes and first value; nothing if refused.
std::string content_of(const fs::path& folder) {
  try {
    const auto dataset = read_minari(folder);
    return std::to_string(dataset.episodes.size()) + " of " +
           std::to_string(dataset.episodes[0].observations(0, 0));
  } catch (const BadInput&) {
    return "";
  }
}

TEST(LearningFaultTest, NoFaultOfAnyCallLeavesHalfOfADataSet) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "set";
  const int calls = faults::try_all(
      folder.path(),
      [&] {
        fs::remove_all(path);
        write_minari(path, dataset_of_steps(2, 1));
      },
      [&] { write_minari(path, dataset_of_steps(3, 2)); },
      [&](const faults::Fault& fault, const faults::Outcome& outcome) {
        SCOPED_TRACE(fault.call);
        const std::string found = content_of(path);
        EXPECT_TRUE(found == "3 of 2.000000" ||
                    (outcome.failed && (found.empty() || found == "2 of 1.000000")))
            << found;
        if (outcome.failed) {
          EXPECT_NE(outcome.message.find(faults::words(fault)), std::string::npos)
              << outcome.message;
        }
      });
  EXPECT_GT(calls, 15);
}

TEST(LearningFaultTest, NoFaultOfAnyCallLeavesHalfOfACheckpoint) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "checkpoint";
  const auto at = [](int iteration) {
    learning::Checkpoint checkpoint;
    checkpoint.method = "cem";
    checkpoint.iteration = iteration;
    checkpoint.arrays["mean"] = Eigen::MatrixXd::Constant(40, 50, iteration);
    return checkpoint;
  };
  faults::try_all(
      folder.path(), [&] { learning::save_checkpoint(path, at(1)); },
      [&] { learning::save_checkpoint(path, at(2)); },
      [&](const faults::Fault&, const faults::Outcome& outcome) {
        const learning::Checkpoint found = learning::load_checkpoint(path);
        EXPECT_TRUE(found.iteration == 2 || (outcome.failed && found.iteration == 1));
        EXPECT_EQ(found.array("mean")(39, 49), found.iteration);
      });
}

}  // namespace
}  // namespace palpate::relocate
