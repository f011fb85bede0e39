// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpate/localization/tracking/tracker.hpp"
#include "palpate/skills/executor.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::skills {

/// How finely a step is searched by rollouts of it.
struct SamplingOptions {
  int samples = 16;              ///< motions rolled out a step; 0: the fingertips just carry along
  double rotation_sigma = 0.02;  ///< rad, spread of the motions' turns
  double translation_sigma = 0.001;  ///< m, of their ways
  double scale_sigma = 0.4;          ///< of their lengths, relative
  double press_sigma = 0.0008;       ///< m, by which fingertips press more or less
  double settle = 0.1;               ///< s, in which the rolled out grasp finds its balance
  double angle_scale = 0.02;         ///< rad of error that count as one
  double distance_scale = 0.002;     ///< m of error that count as one
  double finger_cost = 2.0;          ///< of a finger that loses touch
  double temperature = 0.5;          ///< of the weights exp(-cost / temperature)

  template <class Visitor>
  void visit(Visitor&& v) {
    v("samples", samples, 0, 10000,
      "number of motions rolled out per step; 0: fingertips are only carried along");
    v("rotation_sigma", rotation_sigma, 0.0, 1.0, "rad, spread of the sampled rotations");
    v("translation_sigma", translation_sigma, 0.0, 0.05, "m, spread of the sampled translations");
    v("scale_sigma", scale_sigma, 0.0, 2.0,
      "relative spread of the lengths of the sampled motions");
    v("press_sigma", press_sigma, 0.0, 0.01, "m, spread of the fingertips' motion into the object");
    v("settle", settle, 0.01, 2.0, "s, time in which the grasp comes to rest in a rollout");
    v("angle_scale", angle_scale, 1e-4, 1.0, "rad, rotation error that costs 1");
    v("distance_scale", distance_scale, 1e-5, 0.1, "m, position error that costs 1");
    v("finger_cost", finger_cost, 0.0, 100.0, "cost of a finger that loses contact");
    v("temperature", temperature, 1e-3, 100.0, "temperature T of the weights exp(-cost / T)");
  }
};

/// Looks are few and the fingertips hold the object: no search for slips, which would take the
/// contacts' lasting errors for one.
inline localization::TrackerOptions tracking_in_grasp() {
  localization::TrackerOptions options;
  options.slip_jump = 100;
  return options;
}

struct ReorientOptions {
  double speed = 0.12;            ///< rad/s, of the object
  double linear_speed = 0.01;     ///< m/s
  double period = 0.35;           ///< s of motion between two looks
  double pause = 0.12;            ///< s of rest before a look, averaged
  double longest = 16.0;          ///< s in all
  int patience = 6;               ///< looks in which it may come no nearer to the goal
  double done_angle = 0.05;       ///< rad from the goal that are near enough
  double done_distance = 0.005;   ///< m
  double drift_angle = 0.15;      ///< rad, standard deviation of the tracked pose that ends it
  double drift_distance = 0.010;  ///< m
  int min_fingers = 3;            ///< that must touch
  double regain = 0.001;      ///< m a step by which a fingertip that has lost touch is pressed on
  int regains = 4;            ///< steps in which that is tried
  double grip = 2.5;          ///< force of all fingertips while they turn, times that of the hold
  int tightenings = 2;        ///< steps at first in which they only press
  double tighten_gain = 0.5;  ///< share of the forces' error that such a step makes up for
  double force_gain = 0.0;    ///< the same while it turns
  double friction = 0.5;      ///< that the balance of forces counts on
  SamplingOptions sampling;
  localization::TrackerOptions tracker = tracking_in_grasp();
  tactile::ContactErrorModel errors;  ///< those of the pick's estimates; no option of its own

  template <class Visitor>
  void visit(Visitor&& v) {
    v("speed", speed, 0.001, 5.0, "rad/s, angular speed of the object");
    v("linear_speed", linear_speed, 1e-4, 0.5, "m/s, speed of the object");
    v("period", period, 0.05, 5.0, "s, duration of motion between two updates");
    v("pause", pause, 0.01, 1.0, "s, rest before the pose is estimated");
    v("longest", longest, 0.1, 600.0, "s, time limit of the reorientation");
    v("patience", patience, 1, 1000,
      "number of estimates in a row without progress after which it ends");
    v("done_angle", done_angle, 1e-3, 1.0, "rad, distance from the goal that counts as reached");
    v("done_distance", done_distance, 1e-4, 0.1,
      "m, distance from the goal that counts as reached");
    v("drift_angle", drift_angle, 1e-3, 3.2,
      "rad, standard deviation of the pose at which it ends");
    v("drift_distance", drift_distance, 1e-4, 0.1,
      "m, standard deviation of the pose at which it ends");
    v("min_fingers", min_fingers, 1, 5, "number of fingers that must touch");
    v("regain", regain, 0.0, 0.01,
      "m per step, motion into the object of a fingertip that lost contact");
    v("regains", regains, 0, 100, "number of steps in which contact is sought again");
    v("grip", grip, 0.1, 10.0, "grasp force during the rotation, relative to that of the hold");
    v("tightenings", tightenings, 0, 100,
      "number of steps at the start in which the fingers only press");
    v("tighten_gain", tighten_gain, 0.0, 1.0,
      "share of the force error that each of these steps corrects");
    v("force_gain", force_gain, 0.0, 1.0,
      "share of the force error that a step of the rotation corrects");
    v.section("sampling", sampling);
    v.section("tracker", tracker);
  }
};

enum class ReorientEnd {
  reached,      ///< as near to the goal as asked, by the tracked pose
  out_of_time,  ///< it comes no nearer: the joints do not reach, or it goes on slipping
  drift,        ///< the tracked pose has become too uncertain to go on
  losing,       ///< too few fingers touch, or the next step would lose it, as rolled out
};
std::string_view to_string(ReorientEnd end);

/// Whether a pose's standard deviations are within the drift limit.
bool well_known(const localization::Mode& mode, const ReorientOptions& options);

struct ReorientResult {
  ReorientEnd end = ReorientEnd::out_of_time;
  localization::Posterior posterior;  ///< of the tracked pose at the end, in the world
  localization::PoseError left;  ///< from the tracked pose to the goal; no symmetry divided out
  int steps = 0, rollouts = 0, slips = 0;
  double plan_seconds = 0;  ///< wall time of the rollouts
  double seconds = 0;       ///< of the robot's time
};

/// Turns a held object in the hand to a pose in the world by moving the fingers, the mount at rest.
///
/// Model predictive path integral control (Williams et al., ICRA 2016) on grasp coordinates: a step
/// is a twist of the object and a press of each fingertip; its joint targets are those with which
/// sticking contacts carry the object along (finger_motion). Variants are rolled out in a second
/// world, made of the mesh, the believed hand and the TRACKED pose, and weighed by where they
/// bring the object; after every step the tracker looks what has come of it.
/// @param held  of the object in the hand, in the world; its best mode counts
/// @throws BadInput for a posterior without modes or a goal that is not finite
ReorientResult reorient_in_hand(Executor& robot, const geometry::ObjectModel& object,
                                const localization::Posterior& held,
                                const Eigen::Isometry3d& T_world_goal,
                                const ReorientOptions& options, std::uint64_t seed,
                                int threads = 1);

}  // namespace palpate::skills
