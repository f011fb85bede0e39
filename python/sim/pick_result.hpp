// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <optional>
#include <string>
#include <vector>

#include "rooms.hpp"

namespace palpate::python {

/// What became of a pick, with the object that its posterior shows.
struct PickResult {
  skills::PickResult picked;
  SharedModel model;
  std::vector<evaluation::TrialEvent> events;
  double robot_seconds = 0;
  std::optional<evaluation::TrialMetrics> metrics;  ///< where the simulator's truth is known
  nanobind::object raised = nanobind::none();       ///< by a hand, an arm or a sensor
};

std::string repr(const PickResult& result);
/// For a notebook: the result in a line, its phases, its posterior.
std::string html(const PickResult& result);

void bind_pick_result(nanobind::module_& module);

}  // namespace palpate::python
