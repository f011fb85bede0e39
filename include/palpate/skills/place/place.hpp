// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/skills/explore/height_probe_phase.hpp"
#include "palpate/skills/pick.hpp"
#include "palpate/skills/place/in_hand_phase.hpp"
#include "palpate/skills/place/transport_phase.hpp"
#include "palpate/skills/release/set_down_phase.hpp"
#include "palpate/skills/release/withdraw_phase.hpp"
#include "palpate/skills/reorient/regrasp_plan.hpp"

namespace palpate::skills {

/// All that can be configured of placing.
struct PlaceOptions {
  std::string target;    ///< as parse_target() takes it, or "stable_pose"; empty: none
  int stable_pose = -1;  ///< of the target "stable_pose"; -1: another than the first, drawn
  std::string strategy = "auto";  ///< wrist, fingers, regrasp, or what is needed (PlaceStrategy)
  int picks = 2;                  ///< at most, where the object had to be put back
  double reach = 0.5;             ///< m, how far from the origin a target may be
  double turn_press = 6.0;  ///< as GraspOptions::press_per_weight, if the object may be turned over
  double certain = 0.85;  ///< share of the estimate that must agree on where the object would stand
  bool reestimate = true;      ///< estimate the pose once more over the target
  double turned_motion = 3.0;  ///< of a turned-over object in the hand, times that of the grasp
  bool verify = true;          ///< probe afterwards whether it stands there
  localization::SamePose same;
  FixtureOptions fixture;
  GoalOptions goal;
  TransportOptions transport;
  LowerOptions lower;
  WithdrawOptions withdraw;
  InHandReorientationOptions fingers;
  RegraspSequenceOptions regrasp;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("target", target,
      "fixture, random, stable_pose, x,y,yaw or the 16 numbers of a pose; empty: none");
    v("stable_pose", stable_pose, -1, 1000,
      "index of the stable pose for the target 'stable_pose'; -1: drawn from the others than the "
      "initial one");
    v("strategy", strategy,
      "wrist (one hold), fingers (turn in the hand first), regrasp (planned grasps), auto (the "
      "first that works)");
    v("picks", picks, 1, 10, "number of picks at most, if the object had to be put back");
    v.expert("reach", reach, 0.05, 1.0, "m, largest distance of a target from the origin");
    v("turn_press", turn_press, 0.0, 100.0,
      "least grasp.press_per_weight for targets that may need another stable pose");
    v("certain", certain, 0.0, 1.0, "probability mass that must agree on the pose at the target");
    v("reestimate", reestimate, "estimate the pose once more over the target");
    v.expert("turned_motion", turned_motion, 1.0, 100.0,
             "expected motion in the hand of an object that was turned over, relative to that of "
             "the grasp");
    v("verify", verify, "check by touch afterwards whether the object stands at the target");
    v.section("same", same);
    v.section("fixture", fixture);
    v.section("goal", goal);
    v.section("transport", transport);
    v.expert_section("lower", lower);
    v.expert_section("withdraw", withdraw);
    v.section("fingers", fingers);
    v.section("regrasp", regrasp);
  }

  /// As PickOptions::set_friction().
  void set_friction(double friction) {
    fingers.reorient.friction = friction;
    transport.friction = regrasp.plan.grasp.friction = grasping::kPlannedShare * friction;
  }
};

/// How placing ended.
enum class PlaceStatus {
  placed,       ///< the object stands at the target, as far as was sensed
  ambiguous,    ///< its pose is not known well enough: it was put back
  unreachable,  ///< no position of the mount brings it to the target: it was put back
  refused,      ///< something was in its way at the target: it was put back
  slipped,      ///< it moved in the hand more than is known: it was put back
  lost,         ///< it fell out of the hand
  stuck,        ///< it would not leave the hand, or could not be put back
  missing,      ///< it does not stand where it was put
  under_way,    ///< regrasping ended while it stood in another stable pose on the way to the target
  stopped,      ///< a fault stopped the robot for good
};
std::string_view to_string(PlaceStatus status);

/// Whether the object stands where it came from, so that another pick may go better.
bool was_put_back(PlaceStatus status);

/// What became of placing, as the robot itself knows it.
struct PlaceResult {
  PlaceStatus status = PlaceStatus::lost;
  std::string failed_phase;  ///< empty if all went well
  FaultReport fault;  ///< that stopped the robot for good: nothing is known of the object then
  std::vector<PhaseReport> phases;
  HeldObject held;
  bool certain = false;  ///< known well enough, and expected to stand as the target has it
  double lean = 0;       ///< rad, expected at the target, from the stable pose
  double upright = 1;    ///< probability that it leans by less than PlaceOptions::same
  bool other_stable_pose =
      false;                ///< the target asks for a stable pose other than that it was found in
  bool on_the_way = false;  ///< the target was one on the way to the target proper
  Eigen::Isometry3d T_world_target = Eigen::Isometry3d::Identity();
  std::optional<PlaceGoal> goal;
  std::optional<InHandReorientation> reorientation;  ///< in the hand, where the fingers were used
  planning::Plan motion;                             ///< of the transport
  std::optional<Eigen::Isometry3d> T_world_placed;   ///< as it was let go, estimated
  Eigen::Vector2d lost_at{0, 0};  ///< m, where contacts were sensed last, of a lost object
  /// m, where the object was put down instead, where no way back was free
  std::optional<Eigen::Vector2d> put_aside;
};

/// A pick-and-place task as the robot is given it: what to bring where, and how.
struct PickAndPlaceTask {
  const geometry::ObjectModel& object;
  PlaceTarget target;              ///< in the world, m and rad
  planning::Fixture fixture = {};  ///< on the table, in the world; empty: none
  PickOptions pick = {};
  PlaceOptions place = {};
  std::uint64_t seed = 0;
};

/// Transport and placement (thesis chapter 1) of the object that hangs in the hand after a pick:
/// find where the mount has to go, turn by the fingers where that is asked for or alone makes the
/// target reachable, carry, set down by touch, let go, withdraw, verify by touch. What
/// cannot be done is said, and the object put back gently where it came from.
///
/// It is given what the robot sensed and the ESTIMATED pose; fixture and target are known.
/// @param task    PickAndPlaceTask::pick is what the object was picked with
/// @param picked  held, with an estimate
PlaceResult place(Executor& robot, const PickAndPlaceTask& task, const PickResult& picked,
                  const PhaseObserver& observer = {});

}  // namespace palpate::skills
