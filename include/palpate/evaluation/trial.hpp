// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "palpate/evaluation/start.hpp"
#include "palpate/hand/faulty_hand.hpp"
#include "palpate/recording/sink.hpp"
#include "palpate/simulation/collision/forward_model.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/pick.hpp"
#include "palpate/skills/place/pick_and_place.hpp"

namespace palpate::evaluation {

/// What fails in a trial whose simulation becomes unstable, beside the names of phases.
inline constexpr const char* kUnstable = "simulation";

/// Where the hand's contacts come from.
struct TouchOptions {
  std::string source = "solver";  ///< or "biotac"
  /// Of inferred contacts, beside what each of them says of its error.
  double biotac_point = 0.0005;  ///< m
  double biotac_normal = 0.12;   ///< rad
  double biotac_false = 0.05;    ///< prior share of inferred contacts that are wrong

  template <class Visitor>
  void visit(Visitor&& v) {
    v("source", source,
      "source of contacts: solver (with noise) or biotac (inferred from channels)");
    v("biotac_point", biotac_point, 1e-5, 0.05,
      "m, error of inferred points beyond that which they report");
    v("biotac_normal", biotac_normal, 1e-4, 1.0,
      "rad, error of inferred normals beyond that which they report");
    v("biotac_false", biotac_false, 1e-6, 0.9, "prior share of inferred contacts that are wrong");
  }

  /// @throws BadInput for another source
  [[nodiscard]] bool from_biotacs() const;
};

/// What goes wrong with the hand in a trial.
struct FaultOptions {
  std::string kind = "none";  ///< one of hand::kInjectedFaultNames
  double from = 0;            ///< s
  double length = 0;          ///< s; 0: for good
  int finger = 1, joint = 5, actuator = 9;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("kind", kind,
      "fault of the hand that is injected: none, or one of those of `palpate eval --faults`");
    v("from", from, 0.0, 1e6, "s of robot time at which the fault begins");
    v("length", length, 0.0, 1e6, "s, duration of the fault; 0: until the end");
    v("finger", finger, 0, hand::kMaxFingers - 1,
      "index of the finger that a fault of one fingertip affects");
    v("joint", joint, 0, hand::kMaxJoints - 1,
      "index of the joint that the fault joint_nan affects");
    v("actuator", actuator, 0, hand::kMaxJoints - 1,
      "index of the actuator that the fault joint_stuck affects");
  }

  /// @throws BadInput for another kind
  [[nodiscard]] hand::FaultSchedule schedule(std::uint64_t seed) const {
    const double lasts = length > 0 ? length : std::numeric_limits<double>::infinity();
    return {hand::injected_fault(kind), from, lasts, finger, joint, actuator, seed};
  }
};

/// All that can be configured of a simulated pick. The world differs from what the robot believes
/// as a real one does, unless it is ideal().
struct TrialOptions {
  double friction = 0.5;  ///< of the fingertips on the object, as the robot believes it
  skills::PickOptions pick;
  skills::PlaceOptions place;
  StartOptions start;
  TouchOptions touch;
  skills::SafetyOptions safety;
  FaultOptions fault;
  simulation::WorldOptions world = simulation::WorldOptions::realistic();
  simulation::ForwardModelOptions forward_model;  ///< the world in which motions are rolled out

  template <class Visitor>
  void visit(Visitor&& v) {
    v("friction", friction, 0.05, 2.0,
      "friction coefficient of the fingertips on the object that planning assumes");
    pick.visit(v);
    v.section("place", place);
    v.section("start", start);
    v.section("touch", touch);
    v.section("safety", safety);
    v.expert_section("fault", fault);
    v.section("world", world);
    v.expert_section("arm", world.arm);
    v.expert_section("forward_model", forward_model);
  }

  /// Readings are noisy and links displaced; all else is as the robot believes.
  static TrialOptions ideal();

  /// The pick's options, with the believed friction and the errors of the contacts that it will be
  /// given.
  [[nodiscard]] skills::PickOptions pick_options() const;
  /// With the believed friction.
  [[nodiscard]] skills::PlaceOptions place_options() const;
  /// With the believed friction.
  [[nodiscard]] simulation::ForwardModelOptions forward_model_options() const;
};

/// What the simulator's truth says of a pick. Made after it, for judging alone.
struct TrialMetrics {
  bool lifted = false;  ///< held at last; for the hold 5 cm above the table, slipped below 10 mm
  double slip = 0;      ///< m, of the object in the hand during the hold
  bool has_pose = false;
  bool object_ok = false;  ///< the pose is of the object that it is; else it is never right
  /// Probabilities that it is the object of the pose, and that it is none of the candidates.
  double object_probability = 0, other_probability = 0;
  localization::PoseError error;              ///< modulo symmetry
  localization::PoseError error_no_symmetry;  ///< every pose of a symmetric object distinct
  bool pose_ok = false;                       ///< within 5 deg and 10 mm
  bool pose_tight = false;                    ///< within 2.5 deg and 3.5 mm
  bool covered = false;                       ///< by the modes: localization::covers()
  localization::PoseStatus status = localization::PoseStatus::no_pose;
  double probability = 0;            ///< stated for the best pose
  double free_extent = 0;            ///< rad, to either side about its free axis; 0: it has none
  bool pose_ok_before_lift = false;  ///< as the fingers had met the object, with probing
  bool pose_ok_before_probe = false;
  bool pose_ok_tracked = false;  ///< the pose followed from there to the end of the lift
  double tracked_share = 0;      ///< of the time of following in which it was right
  int probes = 0;                ///< touches of other spots of the object that fingers hold
  double explored_motion = 0;    ///< m, of the object while it was touched before the grasp
  double tip_force = 0;          ///< N, median over the touching fingertips at the end
  double peak_load = 0;          ///< N, largest of the mount, whatever the hand reported
  double peak_tip_force = 0;     ///< N, largest of a fingertip
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< at the end

  /// Whether the pose is wrong, and was stated with a probability above 0.9.
  [[nodiscard]] bool confident_wrong() const { return has_pose && !pose_ok && probability > 0.9; }
};

/// What the simulator's truth says of placing. All errors are modulo symmetry.
struct PlaceMetrics {
  bool placed = false;   ///< let go for good, and within 5 deg and 10 mm of the target at the end
  bool tight = false;    ///< within 3 deg and 5 mm
  bool wrong = false;    ///< let go at the target after a certain estimate, and not `placed`
  bool dropped = false;  ///< it left the hand before the hand let go
  bool in_stable_pose = false;       ///< at the end the target's side is up, wherever it stands
  localization::PoseError error;     ///< of the object at the end from the target
  localization::PoseError estimate;  ///< where it stood before the hand let go, from where believed
  localization::PoseError release;   ///< by which letting go and withdrawing moved it
  Eigen::Isometry3d T_world_target = Eigen::Isometry3d::Identity();  ///< for its true stable pose
};

/// What the robot noted, and when.
struct TrialEvent {
  estimation::TouchEvent event;
  double time = 0;  ///< s of the robot's time
};

/// The events of a log, in the order of time.
std::vector<TrialEvent> trial_events(const estimation::EventLog& log);

struct Trial {
  simulation::Start start;
  skills::PickResult result;
  TrialMetrics metrics;
  std::vector<TrialEvent> events;
  double robot_seconds = 0;                  ///< from start to end
  std::optional<skills::PlaceResult> place;  ///< where the object was held and was to be placed
  PlaceMetrics place_metrics;
  skills::StrategyTaken strategy;  ///< by which it was to be placed
};

/// What run_trial() checks of an object before anything moves, for who is about to write files.
/// @throws BadInput for a source of contacts, a fault, a stable pose or a target that cannot be, or
///         a fixture where the object may stand
void check_trial(const geometry::KnownObject& object, const TrialOptions& options,
                 std::uint64_t seed);

/// One pick in simulation, with placing if options.place has a target, evaluated afterwards.
/// Neither is given the world, only the hand.
/// @param sink  if given, gets every frame (with the truth), phase and estimate
/// @param stop  a request, from any thread, stops the robot within a tick
/// @throws BadInput for a target that cannot be, before anything moves
Trial run_trial(const geometry::ObjectModel& object, const TrialOptions& options,
                std::uint64_t seed, recording::Sink* sink = nullptr,
                const skills::PhaseObserver& observer = {}, std::stop_token stop = {});

/// The same where the robot does not know which object it is, only that it may be one of some
/// candidates, of which it may also be none.
/// @throws BadInput for a target of placing where there are several candidates, or another one
Trial run_trial(const geometry::ObjectModel& object, const estimation::Candidates& candidates,
                const TrialOptions& options, std::uint64_t seed, recording::Sink* sink = nullptr,
                const skills::PhaseObserver& observer = {}, std::stop_token stop = {});

/// The target and the fixture that options ask for; none, an empty one.
/// @param start_stable_pose  in which the object starts, for the target "stable_pose"
/// @throws BadInput for a target that cannot be, for a strategy that does not exist, or for a
///         place.stable_pose of another target than "stable_pose"
std::optional<skills::PlaceTarget> place_target(const geometry::KnownObject& object,
                                                const skills::PlaceOptions& options,
                                                std::uint64_t seed, std::size_t start_stable_pose);
planning::Fixture place_fixture(const geometry::KnownObject& object,
                                const skills::PlaceOptions& options,
                                const std::optional<skills::PlaceTarget>& target);

}  // namespace palpate::evaluation
