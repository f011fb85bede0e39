// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings/pickle.hpp"
#include "pick_result.hpp"

namespace palpate::python {

// Of results in pickles: what Python can see of them.

template <>
struct Fields<skills::PhaseReport> {
  static auto of(skills::PhaseReport& it) {
    return std::tie(it.name, it.status, it.outcome, it.robot_seconds, it.wall_seconds, it.contacts,
                    it.peak_force);
  }
};
template <>
struct Fields<skills::FaultReport> {
  static auto of(skills::FaultReport& it) { return std::tie(it.fault, it.detail, it.time); }
  static void check(const skills::FaultReport& it) {
    if (static_cast<std::size_t>(it.fault) < skills::kFaultNames.size()) return;
    throw BadInput(fmt::format("a fault of number {}", static_cast<int>(it.fault)));
  }
};
template <>
struct Fields<evaluation::TrialEvent> {
  static auto of(evaluation::TrialEvent& it) { return std::tie(it.event, it.time); }
  static void check(const evaluation::TrialEvent& it) {
    if (static_cast<std::size_t>(it.event) < estimation::kTouchEventNames.size()) return;
    throw BadInput(fmt::format("an event of number {}", static_cast<int>(it.event)));
  }
};
template <>
struct Fields<evaluation::TrialMetrics> {  // what Python cannot see is left out
  static auto of(evaluation::TrialMetrics& it) {
    return std::tie(it.lifted, it.has_pose, it.pose_ok, it.error.rotation, it.error.translation);
  }
};
template <>
struct Fields<PickResult> {  // without the posterior, which needs its model
  static auto of(PickResult& it) {
    return std::tie(it.picked.held, it.picked.attempts, it.picked.failed_phase, it.picked.fault,
                    it.picked.phases, it.events, it.robot_seconds, it.metrics, it.place, it.raised);
  }
};

template <>
struct Fields<localization::PoseError> {
  static auto of(localization::PoseError& it) { return std::tie(it.rotation, it.translation); }
};
template <>
struct Fields<evaluation::PlaceMetrics> {  // what Python cannot see is left out
  static auto of(evaluation::PlaceMetrics& it) { return std::tie(it.placed, it.dropped, it.error); }
};
template <>
struct Fields<PlaceResult> {
  static auto of(PlaceResult& it) {
    return std::tie(it.status, it.failed_phase, it.phases, it.strategy, it.reason,
                    it.T_world_target, it.T_world_placed, it.certain, it.upright, it.metrics);
  }
};

}  // namespace palpate::python
