// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/in_hand_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "palpate/core/angle.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "skills/grasp/pressing.hpp"

namespace palpate::skills {
namespace {

constexpr double kRegripSeconds = 0.3;
constexpr double kMargin = 10.0;                       // s, for a last motion slower than asked for
constexpr std::array<double, 2> kShares = {0.5, 1.0};  // of the longest turn that are tried

Eigen::Vector3d limited(const Eigen::Vector3d& rotation, double most) {
  const double angle = rotation.norm();
  return angle > most ? Eigen::Vector3d(most / angle * rotation) : rotation;
}

/// Presses again with what still touches.
void regrip(Executor& robot, const Eigen::Isometry3d& T_world_object,
            const ReorientOptions& options, double weight) {
  const auto& readings = robot.log().readings;
  const auto count = std::min<std::size_t>(readings.size(), 10);
  const auto contacts = tactile::contacts_with_normals(
      tactile::lasting_contacts(std::span(readings).last(count), robot.model(), options.errors));
  if (contacts.empty()) return;
  const auto balanced =
      grasping::distribute_forces(contacts, options.friction, options.grip * 3 * weight,
                                  weight_at(robot, T_world_object, weight));
  robot.move_fingers(pressing_command(robot, contacts, balanced.forces), kRegripSeconds);
}

}  // namespace

Eigen::Vector3d share_of_fingers(const hand::MountPosition& from, const hand::MountPosition& to,
                                 double most) {
  return limited(log_so3(to.pose().linear() * from.pose().linear().transpose()), most);
}

HeldObject turned_in_hand(const HeldObject& held, const hand::MountPosition& mount,
                          const Eigen::Vector3d& rotation_world) {
  const Eigen::Matrix3d R_mount_world = mount.pose().linear().transpose();
  HeldObject turned = held;
  turned.T_mount_object.linear() =
      exp_so3(R_mount_world * rotation_world) * held.T_mount_object.linear();
  turned.T_mount_object_flat = turned.T_mount_object;
  return turned;
}

std::optional<Eigen::Vector3d> turn_that_reaches(
    const HeldObject& held, const hand::MountPosition& mount, const Eigen::Vector3d& towards,
    double most, const std::function<bool(const HeldObject&)>& reaches) {
  std::vector<Eigen::Vector3d> axes;
  if (towards.norm() > 0) axes.push_back(towards.normalized());
  for (int axis : {2, 0, 1}) {
    for (const double sign : {1.0, -1.0}) axes.push_back(sign * Eigen::Vector3d::Unit(axis));
  }
  for (const double share : kShares) {
    for (const auto& axis : axes) {
      const Eigen::Vector3d turn = share * most * axis;
      if (reaches(turned_in_hand(held, mount, turn))) return turn;
    }
  }
  return std::nullopt;
}

double InHandReorientationPhase::time_limit() const {
  const ReorientOptions& reorient = options_.reorient;
  const double last_step = reorient.period + reorient.pause;
  return reorient.longest + last_step + kRegripSeconds + options_.settle + kMargin;
}

PhaseEnd InHandReorientationPhase::run(Executor& robot, PickState& state) {
  const double load = estimation::mean_load(robot.log());
  Eigen::Isometry3d goal = state.estimate.posterior.modes.front().T_frame_object;
  goal.linear() = exp_so3(turn_.asked) * goal.linear();
  turn_.result =
      reorient_in_hand(robot, object_, state.estimate.posterior, goal, options_.reorient, seed_);
  const auto& tracked = turn_.result.posterior.modes.front();
  if (turn_.result.end == ReorientEnd::losing) {
    regrip(robot, tracked.T_frame_object, options_.reorient, object_.object().mass * kGravity);
  }
  robot.wait(options_.settle);
  state.held_load = estimation::mean_load(robot.log());
  turn_.lost = state.held_load < options_.min_weight * load;
  if (turn_.lost) {
    return {false, fmt::format("lost: {:.2f} N of {:.2f} N still hang", state.held_load, load)};
  }
  // Pressing again moves the object by what no look has followed.
  turn_.known = turn_.result.end != ReorientEnd::losing && well_known(tracked, options_.reorient);
  state.estimate.posterior = turn_.result.posterior;
  return {turn_.known,
          fmt::format("{}: {:.1f} deg left of {:.1f}, {} steps, planned in {:.1f} s",
                      to_string(turn_.result.end), kDegreesPerRadian * turn_.result.left.rotation,
                      kDegreesPerRadian * turn_.asked.norm(), turn_.result.steps,
                      turn_.result.plan_seconds)};
}

}  // namespace palpate::skills
