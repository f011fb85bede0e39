// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "palpate/hand/kinematics.hpp"
#include "palpate/planning/waypoints.hpp"

namespace palpate::planning {
namespace {

constexpr double kSlack = 1e-6;  // rad or m, of rounding in files

/// What is wrong with a value in low..high; nothing for one within.
std::string range_fault(std::string_view name, double value, double low, double high,
                        std::string_view unit) {
  if (!std::isfinite(value)) return fmt::format("{} is {}, not a finite number", name, value);
  if (value >= low - kSlack && value <= high + kSlack) return {};
  return fmt::format("{} = {:.4g} {} is outside its range {:.4g} .. {:.4g}", name, value, unit, low,
                     high);
}

void add(std::vector<std::string>& reasons, std::string reason) {
  if (!reason.empty()) reasons.push_back(std::move(reason));
}

void check_mount(const hand::MountPosition& mount, const MountRange& range,
                 std::vector<std::string>& reasons) {
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    add(reasons, range_fault(kMountNames[k], mount.xyz[i], i == 2 ? range.low : -range.side,
                             i == 2 ? range.high : range.side, "m"));
    add(reasons, range_fault(kMountNames[k + 3], mount.ypr[i], -range.turn, range.turn, "rad"));
  }
}

void check_joints(const hand::Description& hand, const hand::JointVector& joints,
                  std::vector<std::string>& reasons) {
  for (int i = 0; i < hand.joint_count(); ++i) {
    const hand::Joint& joint = hand.joints[static_cast<std::size_t>(i)];
    add(reasons, range_fault(joint.name, joints[i], joint.range.low, joint.range.high, "rad"));
  }
  for (const hand::Actuator& actuator : hand.actuators) {
    if (!actuator.coupling) continue;
    const int j2 = actuator.joints[0].joint, j1 = actuator.joints[1].joint;
    if (!(joints[j1] > joints[j2] + kSlack)) continue;
    reasons.push_back(
        fmt::format("{} = {:.4g} rad is beyond {} = {:.4g}, which its tendon does "
                    "not allow",
                    hand.joints[static_cast<std::size_t>(j1)].name, joints[j1],
                    hand.joints[static_cast<std::size_t>(j2)].name, joints[j2]));
  }
}

void check_collision(const Waypoint& waypoint, CollisionChecker& scene,
                     std::vector<std::string>& reasons) {
  const hand::HandCommand command = command_of(waypoint, scene.hand());
  const auto pair = scene.deepest_collision(
      command.mount, hand::joints_in_free_flexion(scene.hand(), command.positions));
  if (!pair) return;
  reasons.push_back(
      fmt::format("{} and {} overlap by {:.1f} mm", pair->first, pair->second, 1e3 * pair->depth));
}

}  // namespace

std::vector<InvalidWaypoint> find_invalid_waypoints(const std::vector<Waypoint>& waypoints,
                                                    CollisionChecker& scene,
                                                    const MountRange& range) {
  std::vector<InvalidWaypoint> invalid;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    std::vector<std::string> reasons;
    check_mount(waypoints[i].mount, range, reasons);
    check_joints(scene.hand(), waypoints[i].joints, reasons);
    if (reasons.empty()) check_collision(waypoints[i], scene, reasons);
    for (std::string& reason : reasons) invalid.push_back({i, std::move(reason)});
  }
  return invalid;
}

}  // namespace palpate::planning
