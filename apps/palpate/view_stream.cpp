// SPDX-License-Identifier: Apache-2.0
#include "view_stream.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "hand_option.hpp"
#include "interrupt.hpp"
#include "palpate/bridge/stream_watcher.hpp"
#include "palpate/core/version.hpp"
#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::app {
namespace {

std::string status_text(const bridge::WatchReport& report) {
  if (report.received.readings == 0) {
    if (report.refused.empty()) return "no reading yet";
    return fmt::format("no reading; senders of {} are best effort", report.refused);
  }
  std::string text = fmt::format("{} readings, {} lost", report.received.readings, report.lost);
  if (report.estimates > 0) {
    text += fmt::format("; {} estimates, a pose {:.0f} ms after its reading", report.estimates,
                        1e3 * report.pose_latency);
  }
  const auto faults =
      report.received.malformed + report.received.out_of_order + report.received.incomplete;
  return faults == 0 ? text : text + fmt::format("; {} messages unused", faults);
}

}  // namespace

int view_stream(const StreamArguments& arguments, const std::function<LiveView&()>& open) {
  const auto hand = load_hand_with_progress(arguments.hand, arguments.common.quiet).hand;
  const auto object = geometry::load_known_object(arguments.object);
  const Interrupt interrupt;
  bridge::Participant participant(arguments.domain ? *arguments.domain : bridge::default_domain());
  const recording::RecordingHeader header{std::string(version()), 0, object, hand, "", false};
  const auto page = open().begin(header, fmt::format("{} in {}", arguments.object, hand.name));
  bridge::StreamWatcher watcher(
      participant, hand, arguments.interface, *page,
      [&page](const bridge::WatchReport& report) { page->status(status_text(report)); });
  watcher.run(interrupt.token());
  const bridge::WatchReport report = watcher.report();
  page->end("the program that watched has ended");
  if (!arguments.common.quiet) fmt::print(stderr, "{}\n", status_text(report));
  return kDone;
}

}  // namespace palpate::app
