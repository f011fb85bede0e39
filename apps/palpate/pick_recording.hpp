// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "palpate/evaluation/belief_recorder.hpp"
#include "palpate/recording/page_stream.hpp"
#include "palpate/recording/writer.hpp"

namespace palpate::app {

/// Where a pick is recorded while it happens: the file, the page of those who watch, and the
/// posterior after each touch.
class PickRecording {
 public:
  /// @param page  null: nobody watches
  PickRecording(const std::filesystem::path& file, const recording::RecordingHeader& header,
                std::unique_ptr<recording::PageStream> page)
      : writer_(file, header), page_(std::move(page)) {}

  /// Computes the posteriors too. Before sink() is asked for.
  /// @param object  kept by reference
  void follow_belief(const geometry::ObjectModel& object, const hand::Description& hand,
                     const skills::PickOptions& options, std::uint64_t seed);

  /// For what happens; this recording outlives it.
  recording::Tee sink();

  /// The pick has ended, and the file is complete.
  void finish(const skills::PickResult& result);

 private:
  recording::Writer writer_;
  std::unique_ptr<recording::PageStream> page_;
  std::optional<evaluation::BeliefRecorder> beliefs_;
};

}  // namespace palpate::app
