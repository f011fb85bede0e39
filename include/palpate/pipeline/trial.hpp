// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/pick.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/simulation/world.hpp"

namespace palpate::pipeline {

/// How the object starts; drawn at random where nothing is fixed.
struct StartOptions {
  int stance = -1;            ///< index into KnownObject::stances; -1: drawn by probability
  double uncertainty = 0.02;  ///< m: its place is within +- of the origin

  template <class Visitor>
  void visit(Visitor&& v) {
    v("stance", stance, -1, 1000, "resting pose; -1: drawn by its probability");
    v("uncertainty", uncertainty, 0.0, 0.1, "m, the object's place is within +- of the origin");
  }
};

/// All that can be configured of a simulated pick.
struct TrialOptions {
  PickOptions pick;
  StartOptions start;
  simulation::WorldOptions world;

  template <class Visitor>
  void visit(Visitor&& v) {
    pick.visit(v);
    v.section("start", start);
    v.section("world", world);
  }
};

/// What the simulator's truth says of a pick. Made after it, for judging alone.
struct Judgement {
  bool lifted = false;  ///< 5 cm above the table for the whole hold, slipped less than 10 mm
  double slip = 0;      ///< m, of the object in the hand during the hold
  bool has_pose = false;
  localization::PoseError error;              ///< modulo symmetry
  localization::PoseError error_no_symmetry;  ///< every pose of a symmetric object distinct
  bool pose_ok = false;                       ///< within 5 deg and 10 mm
  bool pose_tight = false;                    ///< within 2.5 deg and 3.5 mm
  bool truth_in_modes = false;
  bool pose_ok_before_lift = false;  ///< as the fingers had met the object
  double explored_motion = 0;        ///< m, of the object while it was touched before the grasp
  double tip_force = 0;              ///< N, median over the touching fingertips at the end
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< at the end
};

struct Trial {
  simulation::Start start;
  PickResult result;
  Judgement judgement;
};

/// Draws where the object of a trial starts.
/// @throws BadInput for a stance that the object does not have
simulation::Start draw_start(const geometry::KnownObject& object, const StartOptions& options,
                             std::uint64_t seed);

/// One pick in simulation, judged afterwards. The pick itself is given the hand, never the world.
/// @param writer  if given, gets every frame (with the truth), phase and estimate
Trial run_trial(const localization::ObjectModel& object, const TrialOptions& options,
                std::uint64_t seed, recording::Writer* writer = nullptr,
                const PhaseObserver& observer = {});

/// Where the hand waits before a pick.
hand::HandCommand waiting_command();

}  // namespace palpate::pipeline
