// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/transport_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "estimation/slip.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "skills/motion/stretched_way.hpp"
#include "skills/place/weight_bearing.hpp"

namespace palpate::skills {
namespace {

/// What the mount is commanded for a configuration that it is to reach, by what its drives give
/// way.
hand::MountPosition commanded(const hand::MountPosition& wanted,
                              const hand::MountPosition& yielded) {
  return {wanted.xyz + yielded.xyz, wanted.ypr + yielded.ypr};
}

/// Largest distance of the mount from where it was planned to be in each tick, m.
double lag_of(std::span<const hand::HandReading> readings,
              const std::vector<hand::HandCommand>& planned) {
  double most = 0;
  for (std::size_t i = 0; i < std::min(readings.size(), planned.size()); ++i) {
    most = std::max(most, (readings[i].mount.xyz - planned[i].mount.xyz).norm());
  }
  return most;
}

/// A goal whose angles differ from the mount's by less than a turn.
PlaceGoal as_the_mount_stands(PlaceGoal goal, const hand::MountPosition& mount) {
  if ((goal.above.ypr - mount.ypr).cwiseAbs().maxCoeff() < std::numbers::pi) return goal;
  goal.above = hand::nearest_mount(goal.above.pose(), mount);
  goal.mount = hand::nearest_mount(goal.mount.pose(), goal.above);
  return goal;
}

std::string why_no_path(const planning::Plan& motion) {
  if (motion.status != planning::PlanStatus::invalid) return "no free path";
  const auto& fault = motion.invalid.front();
  return fmt::format("{}: {}",
                     fault.waypoint == 0 ? "at the start" : "on the way or over the target",
                     fault.reason);
}

}  // namespace

/// Of mount and fingers, one a tick.
std::vector<hand::HandCommand> TransportPhase::commands(const Executor& robot,
                                                        const hand::MountPosition& yielded) const {
  std::vector<hand::HandCommand> way(motion_.samples.size(), robot.command());
  for (std::size_t i = 0; i < way.size(); ++i) {
    way[i].mount = commanded(motion_.samples[i].mount, yielded);
  }
  if (!options_.bear_weight) return way;
  const WeightBearing bearing(robot, goal_.T_mount_object.translation(),
                              estimation::mean_load(robot.log()), options_.friction);
  for (std::size_t i = 0; i < way.size(); ++i) {
    way[i].positions = bearing.command(motion_.samples[i].mount);
  }
  return way;
}

/// On straight lines of the mount if what carries the hand can follow them, and then come down.
planning::Plan TransportPhase::planned(const Executor& robot, const hand::MountPosition& from,
                                       const hand::MountPosition& yielded) const {
  const hand::JointVector joints = plannable(robot.model(), robot.reading().joints);
  MountPath path = robot.path_to({goal_.above, goal_.mount});
  auto arm = robot.arm_start();
  if (!path.obstacle.empty() && arm) {
    arm->mount = from;
    return planning::plan_with_arm(*arm, path_down(goal_), joints, scene_, options_.plan, seed_);
  }
  std::vector<planning::Waypoint> stops = {{from, joints}};
  for (std::size_t i = 0; i + 2 < path.corners.size(); ++i) {
    const hand::MountPosition& corner = path.corners[i];
    stops.push_back({{corner.xyz - yielded.xyz, corner.ypr - yielded.ypr}, joints});
  }
  stops.push_back({goal_.above, joints});
  return planning::plan(stops, scene_, options_.plan, seed_);
}

PhaseEnd TransportPhase::run(Executor& robot, PickState& state) {
  const double load = estimation::mean_load(robot.log());
  const hand::MountPosition measured = estimation::mean_mount(robot.log());
  const hand::MountPosition yielded = {robot.command().mount.xyz - measured.xyz,
                                       robot.command().mount.ypr - measured.ypr};
  const hand::JointVector joints = plannable(robot.model(), robot.reading().joints);
  scene_.hold(scene_.palm_pose(hand::MountPosition{}, joints).inverse() * goal_.T_mount_object);
  motion_ = planned(robot, measured, yielded);
  if (motion_.status != planning::PlanStatus::ok) return {false, why_no_path(motion_)};

  const std::vector<hand::HandCommand> way = commands(robot, yielded);
  const std::size_t start = robot.log().readings.size() - 1;
  int untouched = 0;
  const auto dropped = [&](const hand::HandReading& reading) {
    untouched = hand::count_contacts(reading) == 0 ? untouched + 1 : 0;
    return untouched >= options_.lost_ticks;
  };
  const bool dropped_on_way = robot.follow(way, dropped) == MotionEnd::stopped;
  goal_ = as_the_mount_stands(goal_, robot.command().mount);
  const std::size_t ticks = robot.log().readings.size() - 1 - start;
  lost_ = dropped_on_way || robot.wait(options_.settle, dropped) == MotionEnd::stopped;
  const double now = estimation::mean_load(robot.log());
  lost_ = lost_ || now < options_.min_weight * load;
  state.held_load = now;
  if (lost_) return {false, fmt::format("lost: {:.2f} N of {:.2f} N still hang", now, load)};
  const double drift =
      estimation::contact_slip(robot.log(), robot.model(), start, robot.log().readings.size() - 1);
  if (drift > options_.max_slip) {
    return {false, fmt::format("slipped by {:.1f} mm", 1e3 * drift)};
  }
  // A slow arm has stretched the motion.
  const auto planned =
      stretched(motion_.samples.front(), motion_.samples, std::max(ticks, motion_.samples.size()));
  const double longer = hand::kTick * static_cast<double>(planned.size() - motion_.samples.size());
  return {true,
          fmt::format("planned in {:.0f} ms, moved in {:.1f} s, at most {:.1f} mm behind, {:.2f} N "
                      "hang, wandered by {:.1f} mm",
                      1e3 * motion_.seconds, motion_.duration() + longer,
                      1e3 * lag_of(std::span(robot.log().readings).subspan(start + 1), planned),
                      now, 1e3 * drift)};
}

}  // namespace palpate::skills
