// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/track_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "palpate/core/error.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::skills {
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
              const estimation::EventLog& log, const tactile::ContactErrorModel& errors,
              const localization::Posterior& start, std::size_t first, std::size_t last,
              const TrackOptions& options, std::uint64_t seed) {
  if (first > last || last >= log.readings.size()) {
    throw BadInput(
        fmt::format("tracking from reading {} to {} of {}", first, last, log.readings.size()));
  }
  Tracked tracked;
  tracked.posterior = start;
  estimation::move(log.readings[first].base.pose().inverse(), tracked.posterior);
  localization::Tracker tracker(object, tracked.posterior, options.tracker,
                                RandomStream(seed, "track"));
  const auto step = static_cast<std::size_t>(std::lround(options.look / hand::kTick));
  const std::span readings(log.readings);
  for (std::size_t i = std::max(first + step, 2 * step); i <= last; i += step) {
    tracked.posterior = tracker.update(look_at(hand, readings.subspan(i - 2 * step, step),
                                               readings.subspan(i - step + 1, step), errors));
    tracked.looks.push_back({i, tracked.posterior.modes.front().T_frame_object});
  }
  tracked.slips = tracker.slips();
  return tracked;
}

PhaseEnd TrackPhase::run(Executor& robot, PickState& state) {
  state.tracked.reset();
  const auto closed = robot.log().at(estimation::TouchEvent::closed),
             held = robot.log().at(estimation::TouchEvent::held);
  const auto& start = state.estimate.posterior;
  if (!closed || !held || start.modes.empty()) return {false, "no pose to follow"};
  state.tracked =
      track(object_, robot.model(), robot.log(), errors_, start, *closed, *held, options_, seed_);
  const Eigen::Isometry3d T_base_start =
      robot.log().readings[*closed].base.pose().inverse() * start.modes.front().T_frame_object;
  const Eigen::Isometry3d& T_base_end = state.tracked->posterior.modes.front().T_frame_object;
  const double turn = rotation_distance(T_base_start.linear(), T_base_end.linear());
  const double way = (T_base_end.translation() - T_base_start.translation()).norm();
  return {true, fmt::format("{:.1f} deg, {:.1f} mm moved in the hand, {} slip{}",
                            180 / std::numbers::pi * turn, 1e3 * way, state.tracked->slips,
                            state.tracked->slips == 1 ? "" : "s")};
}

}  // namespace palpate::skills
