// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/learning/demonstrations/minimum_jerk.hpp"
#include "palpate/learning/demonstrations/retargeting.hpp"
#include "palpate/tasks/relocate/relocate_dynamics.hpp"
#include "palpate/tasks/relocate/synthetic_human.hpp"
#include "palpate/tasks/relocate/training/npg.hpp"

namespace palpate::relocate {

/// How a human's motion becomes the robot's.
struct TranslationOptions {
  learning::FilterOptions filter{0, 0.25, 0.03};
  learning::RetargetOptions retarget;
  double lead = 0.12;       ///< s from the robot's rest to the human's first frame
  double smoothing = 0.03;  ///< s, of the joints' motion
  double lifted = 0.005;    ///< m, displacement of the object from which on it counts as held
  double squeeze = 0.137;   ///< s before that, in which the fingertips begin to press
  double press = 4.64;      ///< N, of each fingertip towards the object's center
  double stiffness = 1500;  ///< N/m, by which the base is held to the motion
  double damping = 80;      ///< N s/m
  double success = 0.05;    ///< m from the target at the end, below which a replay is kept
  /// Standard deviation of what is added to the replayed actions, of -1..1: the demonstrations then
  /// show how to come back to the motion (Laskey et al. 2017).
  double noise = 0;
  double noise_time = 0.05;  ///< s in which that noise changes; 0: white

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("filter", filter);
    v.section("retarget", retarget);
    v("lead", lead, 0.01, 10.0, "s, time from the robot's rest to the human's first frame");
    v("smoothing", smoothing, 0.0, 1.0, "s, time over which the joints' motion is smoothed");
    v("lifted", lifted, 1e-4, 0.1, "m, displacement above which the object counts as held");
    v("squeeze", squeeze, 0.01, 10.0,
      "s, time before the lift at which the fingertips begin to press");
    v("press", press, 0.0, 100.0, "N, force of each fingertip towards the object's centre");
    v("stiffness", stiffness, 0.0, 1e5, "N/m, stiffness with which the base follows the motion");
    v("damping", damping, 0.0, 1e4, "N s/m, damping with which the base follows the motion");
    v("success", success, 1e-3, 1.0, "m, distance from the target below which a replay is kept");
    v("noise", noise, 0.0, 1.0,
      "standard deviation of the noise that is added to the replayed actions");
    v("noise_time", noise_time, 0.0, 10.0, "s, time in which that noise changes; 0: white noise");
  }
};

/// What the robot shall do, at the task's rate.
struct RobotMotion {
  learning::Motion joints;  ///< 30 x n
  Eigen::VectorXd held;     ///< n, 0..1: how far the grasp has closed on the object
  double tip_error = 0;     ///< mean over the frames, m
};

/// Translates a human's sequence in world axes: filters it, retargets every frame, places the arm
/// so that the hand is where the human's was, and finds the motion of least jerk through that.
/// @throws BadInput as filter_hand does, or if there are fewer object poses than frames
RobotMotion translate(const learning::HumanSequence& sequence, learning::Retargeter& retargeter,
                      RelocateDynamics& dynamics, const TranslationOptions& options);

/// One replayed demonstration, as the task saw it.
struct Demonstration {
  std::size_t index = 0;  ///< of the episode of its seed
  RelocateStart start;
  Path path;
  Episode episode;
  Eigen::MatrixXd intended;  ///< 30 x steps: the actions without the noise, -1..1
};

/// Carries out a motion in simulation by inverse dynamics (thesis eq. 7.9).
/// @param noise  of the actions, drawn from if options.noise is above 0
Demonstration replay(const RelocateModel& model, const RobotMotion& motion,
                     RelocateDynamics& dynamics, const RelocateStart& start,
                     const TranslationOptions& options, RandomStream noise = RandomStream(0));

struct DemonstrationOptions {
  SyntheticHumanOptions human;
  TranslationOptions translation;
  EpisodeOptions episode;  ///< whose starts are used; its horizon is not

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("human", human);
    v.section("translation", translation);
    v.section("episode", episode);
  }
};

/// Demonstration number i of a seed: a synthetic human relocates the object, the robot repeats it.
/// @param rest_height  of the object's frame where it rests on the table, m
Demonstration synthetic_demonstration(const RelocateModel& model,
                                      const DemonstrationOptions& options, double rest_height,
                                      std::uint64_t seed, std::size_t index);

/// Height at which the object comes to rest on the table, m.
double rest_height(const RelocateModel& model);

struct DemonstrationSet {
  std::vector<Demonstration> kept;
  std::size_t tried = 0;
};

/// Makes demonstrations until `count` succeeded or `most` were tried; the same for any number of
/// threads.
DemonstrationSet make_demonstrations(const RelocateModel& model,
                                     const DemonstrationOptions& options, std::uint64_t seed,
                                     std::size_t count, std::size_t most, int threads,
                                     const ProgressCallback& progress = {});

/// All frames of all demonstrations, with the intended actions.
Demonstrations frames_of(const std::vector<Demonstration>& demonstrations);

}  // namespace palpate::relocate
