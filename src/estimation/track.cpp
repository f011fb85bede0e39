// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/track.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "palpate/core/error.hpp"
#include "palpate/estimation/estimate.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {
namespace {

using Window = std::span<const hand::HandReading>;

/// Contacts in the hand's base, and how fast the fingertips have moved there since the window
/// before.
localization::TrackFrame look_at(const hand::Description& hand, Window before, Window now,
                                 const tactile::ContactErrorModel& errors) {
  const auto T_before = hand::forward_kinematics(hand, tactile::mean_joints(before));
  const auto T_now = hand::forward_kinematics(hand, tactile::mean_joints(now));
  localization::TrackFrame frame;
  frame.time = now.back().time;
  const double dt = now.back().time - before.back().time;
  for (const auto& contact : tactile::lasting_contacts(now, hand, errors)) {
    const auto link =
        static_cast<std::size_t>(hand.fingers[static_cast<std::size_t>(contact.finger)].link);
    const Eigen::Vector3d was = T_before[link] * (T_now[link].inverse() * contact.p);
    frame.contacts.push_back(contact);
    frame.velocities.push_back((contact.p - was) / dt);
  }
  return frame;
}

}  // namespace

Tracked track(const geometry::ObjectModel& object, const hand::Description& hand,
              const EventLog& log, const tactile::ContactErrorModel& errors,
              const localization::Posterior& start, std::size_t first, std::size_t last,
              const TrackOptions& options, std::uint64_t seed) {
  if (first > last || last >= log.readings.size()) {
    throw BadInput(
        fmt::format("tracking from reading {} to {} of {}", first, last, log.readings.size()));
  }
  Tracked tracked;
  tracked.posterior = start;
  transform(log.readings[first].base.pose().inverse(), tracked.posterior);
  localization::Tracker tracker(object, tracked.posterior, options.tracker,
                                RandomStream(seed, "track"));
  const auto step = static_cast<std::size_t>(std::lround(options.period / hand::kTick));
  const std::span readings(log.readings);
  for (std::size_t i = std::max(first + step, 2 * step); i <= last; i += step) {
    tracked.posterior = tracker.update(look_at(hand, readings.subspan(i - 2 * step, step),
                                               readings.subspan(i - step + 1, step), errors));
    tracked.looks.push_back({i, tracked.posterior.modes.front().T_frame_object});
  }
  tracked.slips = tracker.slips();
  return tracked;
}

}  // namespace palpate::estimation
