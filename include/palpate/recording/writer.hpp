// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "palpate/recording/sink.hpp"

namespace palpate::recording {

/// Writes a recording as it happens, to PATH.partial, which finish() renames to PATH.
///
/// Frames reach the disk once a second of them, events and estimates at once; a program that dies
/// leaves a PATH.partial that read_recording() opens. A writer that is destroyed without finish()
/// flushes what it has and leaves PATH.partial too.
class Writer : public Sink {
 public:
  /// @throws BadInput if the file cannot be written or the header could not be read back
  Writer(std::filesystem::path path, const RecordingHeader& header);
  ~Writer() override;
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  /// Each throws BadInput, with the reason, if something cannot be written; such a recording can
  /// no longer be finished.
  void frame(const Frame& frame) override;
  void event(const Event& event) override;
  /// @throws BadInput for an estimate with a value that is not finite
  void estimate(const EstimateRecord& estimate) override;
  /// @throws BadInput for a belief with a value that is not finite
  void belief(const BeliefRecord& belief) override;

  /// Seals and renames the file once all of it is on the disk; nothing may be written afterwards.
  /// @throws BadInput, with the reason, if that fails now or a write failed before; the file then
  ///         keeps its temporary name
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes a whole recording at once, as finished.
void write_recording(const std::filesystem::path& path, const Recording& recording);

}  // namespace palpate::recording
