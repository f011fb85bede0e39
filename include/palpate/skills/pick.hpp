// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "palpate/estimation/estimate.hpp"
#include "palpate/skills/explore/calibrate_phase.hpp"
#include "palpate/skills/explore/explore_phase.hpp"
#include "palpate/skills/explore/height_probe_phase.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "palpate/skills/grasp/lift_phase.hpp"
#include "palpate/skills/grasp/track_phase.hpp"
#include "palpate/skills/phase.hpp"
#include "palpate/skills/probe/palpation_phase.hpp"
#include "palpate/skills/release/set_down_phase.hpp"
#include "palpate/skills/release/withdraw_phase.hpp"

namespace palpate::skills {

struct PickOptions {
  int attempts = 3;  ///< at most
  /// Rough place on the table, m, of an object that has fallen there: it may rest in no stable
  /// pose. Not an option of the program.
  std::optional<Eigen::Vector2d> fallen_at;
  bool estimate_before_lift = true;  ///< the pose in the closed hand, too
  CalibrateOptions calibrate;
  HeightProbeOptions height_probe;
  ExploreOptions explore;
  GraspOptions grasp;
  PalpationOptions palpation;
  LiftOptions lift;
  LowerOptions lower;        ///< putting it down to grasp it from another side
  WithdrawOptions withdraw;  ///< then
  estimation::TrackOptions track;
  palpate::estimation::EstimationOptions estimation;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("attempts", attempts, 1, 20, "grasp attempts at most");
    v("estimate_before_lift", estimate_before_lift, "estimate the pose in the closed hand, too");
    v.section("calibrate", calibrate);
    v.section("height_probe", height_probe);
    v.section("explore", explore);
    v.section("grasp", grasp);
    v.section("palpation", palpation);
    v.section("lift", lift);
    v.section("lower", lower);
    v.section("withdraw", withdraw);
    v.section("track", track);
    v.section("estimation", estimation);
  }

  /// The friction coefficient of the fingertips on the object that all forces count on.
  void set_friction(double friction) {
    grasp.friction = palpation.friction = friction;
    grasp.plan.friction = grasping::kPlannedShare * friction;
  }
};

/// What became of a pick, as the robot itself knows it.
struct PickResult {
  bool held = false;  ///< the object hangs in the hand
  /// Which candidate the estimate is of, and the probabilities of all; of one alone, 1.
  localization::ObjectProbabilities objects;
  int attempts = 0;
  int regrasps = 0;     ///< from other sides, to distinguish poses
  bool fallen = false;  ///< before this grasp, or an attempt failed: it may rest in no stable pose
  std::string failed_phase;          ///< of the last attempt; empty if all went well
  std::size_t limited_commands = 0;  ///< that a limit of SafetyOptions changed, of the robot so far
  FaultReport fault;  ///< that stopped the robot for good; then nothing is held or estimated
  std::vector<FaultReport> survived;  ///< faults with which the pick went on, of the robot so far
  std::vector<PhaseReport> phases;
  std::optional<localization::Posterior> resting;  ///< pose before the last grasp, in the world
  std::optional<estimation::HeldPoseEstimate>
      before_probe;  ///< in the closed hand, still on the table
  std::optional<estimation::HeldPoseEstimate> before_lift;  ///< there, with what palpation added
  std::optional<estimation::Tracked> tracked;               ///< from there through the lift
  estimation::HeldPoseEstimate estimate;  ///< of what is held; without modes where nothing is
};

struct PlaceResult;

/// Who wants to know of what comes and goes; each may be empty.
struct PhaseObserver {
  std::function<void(std::string_view phase, double time)> on_begin;
  std::function<void(const PhaseReport& report, double time)> on_end;
  std::function<void(const PickResult& picked)> on_picked = {};   ///< a pick has ended
  std::function<void(const PlaceResult& placed)> on_placed = {};  ///< a placing, by no fault
};

/// The main job (thesis chapter 1): calibrate the hand, once a robot; measure how tall the object
/// is, grasp it by touch, lift it, and estimate its pose in the hand, touching more of it while the
/// pose is in doubt and that is informative. A grasp that fails is tried again from another side.
///
/// @param robot  stands free above the table; the object is near the world's origin, or
/// PickOptions::fallen_at
/// @param choose  chooses the grasp, if given
PickResult pick(Executor& robot, const geometry::ObjectModel& object, const PickOptions& options,
                std::uint64_t seed, const PhaseObserver& observer = {},
                const GraspChooser& choose = {});

/// The same where the object is one of several, or none of them. Probabilities are of object and
/// pose; what depends on the object (masses, grasps) is that of the most probable one at the time.
PickResult pick(Executor& robot, const estimation::Candidates& candidates,
                const PickOptions& options, std::uint64_t seed, const PhaseObserver& observer = {},
                const GraspChooser& choose = {});

}  // namespace palpate::skills
