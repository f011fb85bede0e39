// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/grasp_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/skills/explore/height_probe_phase.hpp"
#include "palpate/skills/stop_conditions.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "skills/grasp/closing_watch.hpp"
#include "skills/grasp/possible_poses.hpp"
#include "skills/grasp/predicted_contacts.hpp"
#include "skills/grasp/pressing.hpp"
#include "skills/motion/lowest_part.hpp"
#include "skills/motion/motion_constants.hpp"
#include "skills/motion/take_posture.hpp"
#include "skills/release/opening.hpp"

namespace palpate::skills {
namespace {

constexpr double kSideDistance = 0.22;   // m before the object where a side approach starts
constexpr double kSideOvershoot = 0.03;  // m past the object's place where it ends at the latest
constexpr double kTopDistance = 0.13;    // m above the object where an approach from above starts
constexpr double kTopClearance = 0.003;  // m above the table where it ends at the latest
constexpr double kClear = 0.06;          // m up from where the fingers landed on top
constexpr std::size_t kTouchReadings = 15;
constexpr double kTouchSeconds = kTouchReadings * hand::kTick;
constexpr int kPlans = 6;  // tried for one that can be reached

/// Position of the mount that puts it at `ahead`, `left` of a place, seen along the yaw.
hand::MountPosition mount_at(const PickState& state, const hand::Preshape& preshape, double ahead,
                             double left, double height) {
  const Eigen::Rotation2Dd turn(state.yaw);
  const Eigen::Vector2d xy = state.place + turn * Eigen::Vector2d(ahead, left);
  const hand::Attitude& attitude = preshape.attitudes.front();
  return {{xy.x(), xy.y(), height}, {state.yaw, attitude.pitch, attitude.roll}};
}

/// Comes down until something bears the hand, or its lowest part is just above the table.
void descend_until_load(Executor& robot, const hand::MountPosition& low,
                        const ApproachOptions& how) {
  const auto loaded = lasting_load(robot, -Eigen::Vector3d::UnitZ(), how.contact_load);
  robot.move_mount(low, how.approach_speed, [&](const hand::HandReading& reading) {
    return loaded(reading) || estimation::lowest_of_hand(robot.model(), reading) < kTopClearance;
  });
  robot.wait(0.15);
}

/// The fingers' command when some of them give back the torque that they close with, which would
/// push the object on.
hand::ActuatorVector relaxed(const Executor& robot, const hand::PerFinger<bool>& fingers,
                             const hand::ActuatorVector& friction) {
  hand::ActuatorVector positions = robot.command().positions;
  for (Eigen::Index i = 0; i < positions.size(); ++i) {
    const auto& actuator = robot.actuators()[static_cast<std::size_t>(i)];
    if (actuator.finger < 0 || !fingers[static_cast<std::size_t>(actuator.finger)]) continue;
    const double lead = (robot.reading().torques[i] - friction[i]) / actuator.stiffness;
    positions[i] = std::clamp(positions[i] - lead, actuator.command.low, actuator.command.high);
  }
  return positions;
}

/// Whether what holds up a finger that senses nothing may touch its tip all the same: it has sensed
/// nothing since it began to close, and is not known to sense contact.
/// @param on_pose  else it may meet the object beside its tip
bool may_be_insensitive(const Executor& robot, const FingersDone& done, bool on_pose, int finger) {
  if (!robot.trust().trusted(finger)) return true;
  return on_pose && !robot.trust().cleared(finger) && !done.met()[static_cast<std::size_t>(finger)];
}

/// The first plan to which the mount can be brought, of those that avoid the others' yaws.
std::optional<grasping::GraspPlan> reachable_plan(
    const Executor& robot, std::vector<double> avoided,
    const std::function<std::optional<grasping::GraspPlan>(const std::vector<double>&)>& plan) {
  for (int i = 0; i < kPlans; ++i) {
    const auto found = plan(avoided);
    if (!found || robot.obstacle(found->mount).empty()) return found;
    avoided.push_back(found->mount.ypr.x());
  }
  return std::nullopt;
}

}  // namespace

double pressure(const GraspOptions& options, const geometry::KnownObject& object) {
  return std::max(options.min_press, options.press_per_weight * object.mass * kGravity);
}

PhaseEnd GraspPhase::run(Executor& robot, PickState& state) {
  std::vector<double> tried_yaws = state.tried_yaws;
  auto planned = plan(robot, state, tried_yaws);
  if (!planned) return grasp_unplanned(robot, state);
  Hold hold = close_as_planned(robot, state, *planned);
  if (robot.trust().suspected(robot.model().thumb)) return held_up(robot);
  int closings = 1;
  for (; hold.forces.wrench_residual > options_.max_wrench_residual && closings < options_.closings;
       ++closings) {
    tried_yaws.push_back(planned->mount.ypr.x());
    planned = plan(robot, state, tried_yaws);
    if (!planned || planned->cost > hold.forces.wrench_residual) break;
    if (std::count(tried_yaws.begin(), tried_yaws.end(), planned->mount.ypr.x()) > 0) break;
    release(robot);
    hold = close_as_planned(robot, state, *planned);
    if (robot.trust().suspected(robot.model().thumb)) return held_up(robot);
  }
  state.tried_yaws.push_back(state.yaw);
  press(robot, hold);
  return end(robot, hold,
             closings == 1 ? "planned grasp" : fmt::format("planned grasp, closing {}", closings));
}

GraspPhase::Hold GraspPhase::close_as_planned(Executor& robot, PickState& state,
                                              const grasping::GraspPlan& plan) const {
  state.yaw = plan.mount.ypr.x();
  approach(robot, plan, state.clear_height);
  close(robot, {robot.model().postures.top, options_.top.closing_rate, true});
  return balance(robot, state);
}

PhaseEnd GraspPhase::grasp_unplanned(Executor& robot, PickState& state) {
  const bool from_side =
      state.height >= options_.side_from && !robot.model().postures.side.attitudes.empty();
  if (from_side) {
    approach_from_side(robot, state);
  } else {
    approach_from_above(robot, state);
  }
  state.tried_yaws.push_back(state.yaw);
  const hand::Postures& postures = robot.model().postures;
  close(robot, {from_side ? postures.side : postures.top,
                from_side ? options_.side.closing_rate : options_.top.closing_rate, false});
  if (robot.trust().suspected(robot.model().thumb)) return held_up(robot);
  const Hold hold = balance(robot, state);
  press(robot, hold);
  return end(robot, hold, from_side ? "side grasp" : "top grasp");
}

/// The grasp ends before the thumb pushes the object out of the hand.
PhaseEnd GraspPhase::held_up(const Executor& robot) const {
  const auto thumb = static_cast<std::size_t>(robot.model().thumb);
  return {false, fmt::format("{} is blocked by something that it does not sense",
                             robot.model().fingers[thumb].name)};
}

PhaseEnd GraspPhase::end(const Executor& robot, const Hold& hold, std::string_view grasp) const {
  const int contacts = hand::count_contacts(robot.reading());
  return {contacts >= options_.min_contacts,
          fmt::format("{}, {} contacts, wrench residual {:.2f}", grasp, contacts,
                      hold.forces.wrench_residual)};
}

std::optional<grasping::GraspPlan> GraspPhase::plan(const Executor& robot, const PickState& state,
                                                    const std::vector<double>& tried_yaws) const {
  if (!state.resting) return std::nullopt;
  if (choose_) {
    if (auto chosen = choose_(*state.resting)) return chosen;
  }
  const hand::Preshape& preshape = robot.model().postures.top;
  const grasping::ClosingLaw law(robot.model(), kPlannedRate, preshape.closed);
  const auto path = grasping::closing_trajectory(robot.model(), preshape.open, law);
  grasping::GraspPlanOptions options = options_.plan;
  options.press = pressure(options_, object_.object());
  const auto poses = possible_poses(*state.resting);
  std::optional<grasping::GraspPlan> best;
  for (const hand::Attitude& attitude : preshape.attitudes) {
    const auto plan = reachable_plan(robot, tried_yaws, [&](const std::vector<double>& avoided) {
      return grasping::plan_grasp(object_, poses, path, attitude, options, avoided);
    });
    if (plan && (!best || plan->expected_cost < best->expected_cost)) best = plan;
    if (best && best->expected_cost < options_.good_cost) break;
  }
  return best;
}

void GraspPhase::approach(Executor& robot, const grasping::GraspPlan& plan,
                          double clear_height) const {
  hand::MountPosition above = plan.mount;
  above.xyz.z() += kTopDistance;
  travel_to(robot, above, robot.model().postures.top, clear_height);
  descend_until_load(robot, plan.mount, options_.top);
}

void GraspPhase::travel_to(Executor& robot, const hand::MountPosition& start,
                           const hand::Preshape& preshape, double clear_height) const {
  hand::MountPosition up = robot.command().mount;
  const hand::Attitude now = attitude_of(up), then = attitude_of(start);
  const double low =
      std::min(lowest_on_way(robot.model(), robot.command().positions, now, preshape.open, now),
               lowest_on_way(robot.model(), preshape.open, now, preshape.open, then));
  const double safe = std::max(kFreeHeight, clear_height - low);
  up.xyz.z() = std::max(up.xyz.z(), safe);
  robot.move_mount(up, options_.travel_speed);
  take_posture(robot, preshape.open, 0.4);
  hand::MountPosition above = start;
  above.xyz.z() = std::max(start.xyz.z(), safe);
  robot.move_mount(above, options_.travel_speed);
  robot.move_mount(start, options_.travel_speed);
  tare(robot);
}

void GraspPhase::approach_from_side(Executor& robot, const PickState& state) const {
  const hand::Preshape& preshape = robot.model().postures.side;
  const double ahead = preshape.offset.x();
  travel_to(robot, mount_at(state, preshape, ahead, -kSideDistance, preshape.height), preshape,
            state.clear_height);
  const Eigen::Vector3d forward(-std::sin(state.yaw), std::cos(state.yaw), 0);
  const ApproachOptions& how = options_.side;
  robot.move_mount(mount_at(state, preshape, ahead, kSideOvershoot, preshape.height),
                   how.approach_speed, lasting_load(robot, forward, how.contact_load));
  hand::MountPosition further = robot.command().mount;
  further.xyz += how.push * forward;
  robot.move_mount(further, 0.5 * how.approach_speed);
  robot.wait(0.1);
}

void GraspPhase::approach_from_above(Executor& robot, PickState& state) const {
  const hand::Preshape& preshape = robot.model().postures.top;
  const Eigen::Vector2d& offset = preshape.offset;
  travel_to(robot, mount_at(state, preshape, offset.x(), offset.y(), state.height + kTopDistance),
            preshape, state.clear_height);
  for (int turn = 0; turn < options_.turns; ++turn) {
    descend(robot, state);
    const bool beside = estimation::lowest_of_hand(robot.model(), robot.reading()) <
                        state.height - options_.min_depth;
    if (beside || turn + 1 == options_.turns) break;
    state.yaw += std::numbers::pi / options_.turns;
    hand::MountPosition raised = robot.command().mount;
    raised.xyz.z() += kClear;
    robot.move_mount(raised, options_.travel_speed);
    robot.move_mount(mount_at(state, preshape, offset.x(), offset.y(), raised.xyz.z()),
                     options_.travel_speed);
    robot.wait(0.2);
  }
}

void GraspPhase::descend(Executor& robot, const PickState& state) const {
  const hand::Preshape& preshape = robot.model().postures.top;
  const hand::MountPosition low =
      mount_at(state, preshape, preshape.offset.x(), preshape.offset.y(), 0.02);
  descend_until_load(robot, low, options_.top);
}

/// Each finger closes until it touches, or is held up by something that it does not sense.
void GraspPhase::close(Executor& robot, const Closing& how) const {
  const hand::Preshape& preshape = how.preshape;
  const grasping::ClosingLaw law(robot.model(), how.rate, preshape.closed);
  FingersDone done(robot.model());
  ClosingFriction friction(robot.model());
  UnsensedContacts unsensed(robot.model(), preshape.contact_torque);
  hand::PerFinger<bool> just_met{};
  const double end = robot.time() + options_.longest_close;
  while (robot.time() < end && !done.settled()) {
    robot.set_grip(
        Grip{law, friction.limits(robot.model(), preshape.contact_torque), done.still_closing()});
    const auto command = relaxed(robot, just_met, friction.torques());
    if (robot.move_fingers(command, hand::kTick) == MotionEnd::timed_out) break;
    friction.update(robot.reading());
    const auto before = done.met();
    done.update(robot.reading(), robot.command());
    for (std::size_t i = 0; i < just_met.size(); ++i) just_met[i] = done.met()[i] && !before[i];
    if (!friction.known()) continue;
    for (const int finger : unsensed.update(robot.reading(), friction.torques())) {
      if (!may_be_insensitive(robot, done, how.on_pose, finger)) continue;
      robot.trust().suspect(finger);
      done.stop(finger);
      just_met[static_cast<std::size_t>(finger)] = true;
    }
    if (robot.trust().suspected(robot.model().thumb)) break;
  }
  robot.move_fingers(relaxed(robot, just_met, friction.torques()), hand::kTick);
  robot.set_grip(std::nullopt);
  robot.wait(kTouchSeconds);
}

/// The forces that cancel best, together with the weight: the fingers bear it from the first, so
/// that they do not give way when the table no longer does.
GraspPhase::Hold GraspPhase::balance(const Executor& robot, const PickState& state) const {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const auto window = readings.last(std::min(readings.size(), kTouchReadings));
  Hold hold;
  hold.contacts =
      tactile::contacts_with_normals(tactile::lasting_contacts(window, robot.model(), {}));
  if (state.resting) {
    add_predicted_contacts(robot, object_, state.resting->modes.front().T_frame_object,
                           hold.contacts);
  }
  std::optional<grasping::Load> load;
  if (state.resting) {
    load = weight_at(robot, state.resting->modes.front().T_frame_object,
                     object_.object().mass * kGravity);
  }
  hold.forces = grasping::distribute_forces(hold.contacts, options_.friction,
                                            pressure(options_, object_.object()), load);
  return hold;
}

void GraspPhase::press(Executor& robot, const Hold& hold) const {
  robot.add_event(estimation::TouchEvent::closed);
  robot.move_fingers(pressing_command(robot, hold.contacts, hold.forces.forces),
                     options_.ramp_seconds);
  robot.wait(0.2);
}

void GraspPhase::release(Executor& robot) const {
  open_yielding(robot);
  hand::MountPosition up = robot.command().mount;
  up.xyz.z() += kTopDistance;
  robot.move_mount(up, options_.travel_speed);
}

}  // namespace palpate::skills
