// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"
#include "palpate/tasks/relocate/training/trainer.hpp"

namespace palpate::app {

/// A search whose rollouts many machines run, by files in its folder: ask.jsonl has a line for each
/// candidate that is to be rolled out, scores-*.jsonl have the results.
struct RoundFiles {
  explicit RoundFiles(std::filesystem::path search) : folder(std::move(search)) {}
  std::filesystem::path ask() const { return folder / "ask.jsonl"; }

  std::filesystem::path folder;
};

/// Names of the scores that are there.
std::vector<std::string> score_names(const RoundFiles& files);

/// @throws BadInput unless something has been asked for
void check_asked(const RoundFiles& files);

/// Writes what is asked for. @return how many rollouts of a candidate
std::size_t write_requests(const RoundFiles& files, relocate::SearchTrainer& trainer);

/// Runs lines I, I + N, ... of ask.jsonl, and writes scores-I-of-N.jsonl.
/// @param share  "I/N"
/// @return how many
/// @throws BadInput for a share that is none, and for requests that are not of this generation
std::size_t run_share(const RoundFiles& files, const std::string& share,
                      const relocate::SearchTrainer& trainer);

/// Takes all results; those of earlier rounds mean nothing. @return figures, where they end an
/// iteration
/// @throws BadInput, naming what is missing, or file and line of what cannot be
std::optional<relocate::Metrics> take_results(const RoundFiles& files,
                                              relocate::SearchTrainer& trainer);

/// Says how many candidates are rolled out, as JSON if that is wanted.
void print_round(const CommonOptions& common, const RoundFiles& files, int generation,
                 std::size_t rollouts);

/// Removes requests and scores.
void remove_rounds(const RoundFiles& files);

}  // namespace palpate::app
