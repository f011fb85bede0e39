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

/// Contacts in the hand's mount, and how fast the fingertips have moved there since the window
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

Tracked track(const TrackInput& input, const TrackOptions& options, std::uint64_t seed) {
  const std::span readings(input.log.readings);
  if (input.first > input.last || input.last >= readings.size()) {
    throw BadInput(fmt::format("tracking from reading {} to {} of {}", input.first, input.last,
                               readings.size()));
  }
  Tracked tracked;
  tracked.posterior = input.start;
  transform(readings[input.first].mount.pose().inverse(), tracked.posterior);
  localization::Tracker tracker(input.object, tracked.posterior, options.tracker,
                                RandomStream(seed, "track"));
  const auto step = static_cast<std::size_t>(std::lround(options.period / hand::kTick));
  for (std::size_t i = std::max(input.first + step, 2 * step); i <= input.last; i += step) {
    const Window before = readings.subspan(i - 2 * step, step);
    const Window now = readings.subspan(i - step + 1, step);
    tracked.posterior = tracker.update(look_at(input.hand, before, now, input.errors));
    tracked.looks.push_back({i, tracked.posterior.modes.front().T_frame_object});
  }
  tracked.slips = tracker.slips();
  return tracked;
}

}  // namespace palpate::estimation
