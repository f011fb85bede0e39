// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <optional>
#include <string>
#include <vector>

#include "libraries.hpp"

namespace palpate::python {

/// What became of placing, and by which strategy.
struct PlaceResult {
  skills::PlaceStatus status = skills::PlaceStatus::lost;
  std::string failed_phase;
  std::vector<skills::PhaseReport> phases;
  std::string strategy, reason;
  Eigen::Isometry3d T_world_target = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> T_world_placed;
  bool certain = false;
  double upright = 1;
  std::optional<evaluation::PlaceMetrics> metrics;  ///< where the simulator's truth is known
};

/// @param metrics  none for a hand whose object's truth is not known
PlaceResult place_result(const skills::PlaceResult& placed, const skills::StrategyTaken& strategy,
                         const std::optional<evaluation::PlaceMetrics>& metrics);

/// What became of a pick, with the object that its posterior shows.
struct PickResult {
  skills::PickResult picked;
  SharedModel model;
  std::vector<evaluation::TrialEvent> events;
  double robot_seconds = 0;
  std::optional<evaluation::TrialMetrics> metrics = {};  ///< where the truth is known
  std::optional<PlaceResult> place = {};                 ///< where the object was to be placed
  nanobind::object raised = nanobind::none();            ///< by a hand, an arm or a sensor
};

std::string repr(const PickResult& result);
/// For a notebook: the result in a line, its phases, its posterior.
std::string html(const PickResult& result);

void bind_pick_result(nanobind::module_& module);
void bind_place_result(nanobind::module_& module);

}  // namespace palpate::python
