// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/estimation/estimate.hpp"
#include "palpate/estimation/track.hpp"
#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {

enum class PhaseStatus { ok, failed, timed_out, fault };
std::string_view to_string(PhaseStatus status);

/// What a phase reports of itself: whether its own success test passed, and in words.
struct PhaseEnd {
  bool ok = false;
  std::string outcome;
  bool unreachable = false;  ///< what carries the hand could not take it along a motion's way
};

/// What became of a phase.
struct PhaseReport {
  std::string name;
  PhaseStatus status = PhaseStatus::failed;
  std::string outcome;
  double robot_seconds = 0;
  double wall_seconds = 0;
  int contacts = 0;       ///< fingertip contacts at its end
  double peak_force = 0;  ///< largest force of a fingertip contact during it, N
  /// As PhaseEnd has it; no file and no pickle keeps it, for the outcome says it.
  bool unreachable = false;
};

/// What the phases hand on to each other: how the object is to be held, and how the hand holds it.
struct PickState {
  double height = 0;                               ///< of the object, as measured, m
  double clear_height = 0.19;                      ///< m above the table, over all that may stand
  Eigen::Vector2d place{0, 0};                     ///< rough place of the object, m
  std::optional<localization::Posterior> resting;  ///< pose on the table, in the world
  double yaw = 0;                                  ///< direction from which to grasp, rad
  std::vector<double> tried_yaws;                  ///< of grasps that have been tried, rad
  double held_load = 0;                            ///< weight measured after the lift, N
  estimation::HeldPoseEstimate estimate;           ///< of the held object, in the world
  std::optional<estimation::Tracked> tracked;      ///< how it went from the closed hand on
  std::optional<grasping::GraspPlan> next_grasp;   ///< that is to resolve what this one left open
};

/// A step of a pick. Its success test sees only what the hand sensed.
class Phase {
 public:
  virtual ~Phase() = default;
  virtual std::string_view name() const = 0;
  virtual double time_limit() const = 0;  ///< s of the robot's time
  virtual PhaseEnd run(Executor& robot, PickState& state) = 0;
};

/// Runs a phase under its time limit and reports on it. A phase that a fault has stopped has the
/// status fault; one that throws anything else leaves the robot safe, and so does this.
PhaseReport run_phase(Phase& phase, Executor& robot, PickState& state);

}  // namespace palpate::skills
