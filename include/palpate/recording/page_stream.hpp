// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "palpate/hand/visuals.hpp"
#include "palpate/recording/sink.hpp"

namespace palpate::recording {

/// A recording as it is sent to the replay page while it comes about: one line of JSON for each new
/// thing, for viewer/live.js.
///
/// Frames are thinned; everything else is passed on. Any thread may call it.
class PageStream : public Sink {
 public:
  using Send = std::function<void(std::string message)>;

  struct Options {
    double period = 0.05;  ///< s of the robot's time from one frame to the next, at least
  };

  /// @param header  as of the recording; kept
  /// @param send  gets each message; called by one thread at a time
  PageStream(RecordingHeader header, Send send, const Options& options);
  PageStream(RecordingHeader header, Send send)
      : PageStream(std::move(header), std::move(send), Options{}) {}
  ~PageStream() override;
  PageStream(const PageStream&) = delete;
  PageStream& operator=(const PageStream&) = delete;

  void frame(const Frame& frame) override;
  void event(const Event& event) override;
  void estimate(const EstimateRecord& estimate) override;
  void belief(const BeliefRecord& belief) override;

  /// What the page shows beside in words, as of a stream's faults.
  void status(const std::string& text);
  /// Nothing follows. @param outcome  in words
  void end(const std::string& outcome);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The page that shows a stream, as replay_page() makes it of a recording without frames.
std::string live_page(const RecordingHeader& header, const hand::HandVisuals& visuals,
                      std::string_view page, std::string_view script, std::string_view title);

}  // namespace palpate::recording
