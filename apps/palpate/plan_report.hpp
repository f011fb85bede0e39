// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "palpate/planning/execution.hpp"
#include "palpate/planning/planner.hpp"

namespace palpate::app {

/// What `palpate plan --json` prints.
nlohmann::json plan_report(const planning::Plan& plan,
                           const std::optional<planning::TrackingError>& tracking);

/// One line of each waypoint's fault, the first ones.
std::string describe_invalid(const std::vector<planning::InvalidWaypoint>& invalid);

/// The samples with their times: t_s, x..roll, and the joints in free flexion.
std::string path_csv(const std::vector<hand::HandCommand>& samples, const hand::Description& hand);

/// Every coordinate that moves over time, with the measured ones where there are any, as an SVG.
std::string plot_motion(const planning::Plan& plan,
                        const std::optional<planning::TrackingError>& tracking,
                        const hand::Description& hand);

}  // namespace palpate::app
