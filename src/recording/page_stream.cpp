// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/page_stream.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>

#include "recording/page_data.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

/// ms since 1970, as a browser's clock counts them.
double wall_clock_ms() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

}  // namespace

struct PageStream::Impl {
  RecordingHeader header;
  Send send_message;
  Options options;
  std::mutex mutex;
  std::vector<Event> events;
  std::vector<std::pair<double, FrameTruth>> truths;  // by the time, of the frames that were sent
  std::optional<double> origin;                       // s, as of the page's times
  std::optional<double> sent_at;  // s, time of the last frame that was sent as it was due
  TouchesShown touches;           // since then
  double now = 0;                 // s
  bool has_beliefs = false;       // other than those of the events

  void send(const char* kind, json content) {
    const json message = {{kind, std::move(content)}};
    send_message(message.dump(-1, ' ', false, json::error_handler_t::replace));
  }

  /// An estimate of an earlier time is compared with the truth of then.
  [[nodiscard]] const FrameTruth* truth_at(double time) const {
    const auto after = std::upper_bound(
        truths.begin(), truths.end(), time + hand::kTick / 2,
        [](double t, const std::pair<double, FrameTruth>& known) { return t < known.first; });
    return after == truths.begin() ? nullptr : &std::prev(after)->second;
  }

  /// Where the page's clock is 0: the first frame or event decides.
  double origin_at(double time) {
    if (!origin) origin = page_origin(time);
    return *origin;
  }

  [[nodiscard]] PageContext context_at(double time) const {
    return {origin.value_or(page_origin(time)), truth_at(time), header.object.symmetries};
  }

  void add(const BeliefRecord& belief) {
    send("belief", belief_to_json(belief, context_at(belief.time)));
  }

  /// Whether the frame is shown: the first, one a period, one after a step back in time, and those
  /// in which another finger touches.
  bool takes(const hand::HandReading& reading) {
    const double due = sent_at.value_or(-1e9) + options.period - hand::kTick / 2;
    const bool early = sent_at && reading.time >= *sent_at && reading.time < due;
    if (!early) {
      sent_at = reading.time;
      touches.begin();
    }
    return touches.add(reading) || !early;
  }
};

PageStream::PageStream(RecordingHeader header, Send send, const Options& options)
    : impl_(new Impl) {
  impl_->header = std::move(header);
  impl_->send_message = std::move(send);
  impl_->options = options;
}

PageStream::~PageStream() = default;

void PageStream::frame(const Frame& frame) {
  const std::lock_guard lock(impl_->mutex);
  impl_->now = frame.reading.time;
  if (!impl_->takes(frame.reading)) return;
  if (frame.truth) impl_->truths.emplace_back(frame.reading.time, *frame.truth);
  json content = frame_to_json(frame, impl_->header.hand, impl_->origin_at(frame.reading.time));
  content["sent_ms"] = wall_clock_ms();
  impl_->send("frames", std::move(content));
}

void PageStream::event(const Event& event) {
  const std::lock_guard lock(impl_->mutex);
  if (holds_belief(event)) {
    if (!impl_->has_beliefs) impl_->add(belief_of(event));
    return;
  }
  impl_->events.push_back(event);
  impl_->send("story", events_to_json(impl_->events, std::max(impl_->now, event.time),
                                      impl_->origin_at(event.time)));
}

void PageStream::estimate(const EstimateRecord& estimate) {
  const std::lock_guard lock(impl_->mutex);
  impl_->send("estimate", estimate_to_json(estimate, impl_->context_at(estimate.time)));
}

void PageStream::belief(const BeliefRecord& belief) {
  const std::lock_guard lock(impl_->mutex);
  impl_->has_beliefs = true;
  impl_->add(belief);
}

void PageStream::status(const std::string& text) {
  const std::lock_guard lock(impl_->mutex);
  impl_->send("status", text);
}

void PageStream::end(const std::string& outcome) {
  const std::lock_guard lock(impl_->mutex);
  impl_->send("end", outcome);
}

}  // namespace palpate::recording
