// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>

#include "palpate/grasping/closing_law.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

/// How fast and how hard the hand comes to the object and closes; hand::Preshape says in which
/// posture.
struct ApproachOptions {
  double approach_speed = 0.10;  ///< m/s
  double contact_load = 1.0;     ///< N on the mount that ends the approach
  double push = 0;               ///< m to go on after that (side grasp)
  double closing_rate = 0.25;    ///< rad/s of an actuator that closes at speed 1

  template <class Visitor>
  void visit(Visitor&& v) {
    v("approach_speed", approach_speed, 0.001, 0.5, "m/s, speed of the approach");
    v("contact_load", contact_load, 0.05, 50.0, "N, load on the mount that ends the approach");
    v("push", push, 0.0, 0.1, "m, motion that continues after the approach has touched");
    v("closing_rate", closing_rate, 0.01, 20.0,
      "rad/s, speed of an actuator that closes at relative speed 1");
  }
};

struct GraspOptions {
  double side_from = 0.3;  ///< objects at least this tall are grasped from the side, m
  ApproachOptions side{.push = 0.0146, .closing_rate = 1.76};
  ApproachOptions top;
  int turns = 4;                  ///< directions tried from above when fingers land on the object
  double min_depth = 0.02;        ///< m below the object's top that the fingers must reach
  double travel_speed = 0.5;      ///< m/s
  double longest_close = 12.0;    ///< s until all fingers have met the object
  double ramp_seconds = 0.8;      ///< from touching to pressing
  double press_per_weight = 4.5;  ///< of all fingertips together, by the object's weight
  double min_press = 5.0;         ///< N
  double good_cost = 0.05;        ///< of a plan with which the search ends
  grasping::GraspPlanOptions plan;
  double friction = 0.5;             ///< that the balance of forces counts on
  int closings = 4;                  ///< from other sides, at most, until the forces balance
  double max_wrench_residual = 0.1;  ///< of the forces with which the fingers would press
  int min_contacts = 2;              ///< fingertip contacts that count as a grasp

  template <class Visitor>
  void visit(Visitor&& v) {
    v("side_from", side_from, 0.0, 0.5, "m, objects at least this tall are grasped from the side");
    v.expert("turns", turns, 1, 36,
             "number of directions from above that are tried if fingers land on the object");
    v.expert("min_depth", min_depth, 0.0, 0.2,
             "m, depth below the object's top that the fingers must reach");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, speed through the air");
    v.expert("longest_close", longest_close, 0.1, 30.0,
             "s, time limit until all fingers have met the object");
    v.expert("ramp_seconds", ramp_seconds, 0.01, 10.0,
             "s, time over which the grasp force is built up");
    v("press_per_weight", press_per_weight, 0.0, 100.0,
      "total grasp force of the fingertips, relative to the object's weight");
    v.expert("good_cost", good_cost, 0.0, 2.0, "cost of a grasp plan at which the search ends");
    v("min_press", min_press, 0.1, 100.0, "N, least total grasp force of the fingertips");
    v("closings", closings, 1, 20,
      "number of closings from other sides at most, until the forces balance");
    v("max_wrench_residual", max_wrench_residual, 0.0, 10.0,
      "largest wrench residual of the planned grasp forces, relative to them");
    v("min_contacts", min_contacts, 0, 20, "number of fingertip contacts that a grasp needs");
    v.expert_section("plan", plan);
    v.expert_section("side", side);
    v.expert_section("top", top);
  }
};

/// With how much (N) all fingertips together press on an object.
double pressure(const GraspOptions& options, const geometry::KnownObject& object);

/// Chooses a grasp for the estimated resting pose, before every closing; nothing leaves the choice
/// to the phase, the same grasp again ends it.
using GraspChooser =
    std::function<std::optional<grasping::GraspPlan>(const localization::Posterior&)>;

/// Brings the hand to the object as planned on its resting pose, and closes it by touch. Where the
/// fingers' forces would not balance, it opens and closes again from another side; then it presses.
/// Without a pose it goes for the rough place, from the side or from above by the object's height.
class GraspPhase : public Phase {
 public:
  /// @param choose  asked first, if given
  GraspPhase(const GraspOptions& options, const geometry::ObjectModel& object,
             GraspChooser choose = {})
      : options_(options), object_(object), choose_(std::move(choose)) {}
  std::string_view name() const override { return "grasp"; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  struct Closing {
    const hand::Preshape& preshape;
    double rate;   ///< rad/s
    bool on_pose;  ///< else fingers may meet the object beside their tips, and sense nothing
  };
  /// What the closed fingers sense, and the forces with which they are to press.
  struct Hold {
    std::vector<tactile::Contact> contacts;
    grasping::ForceDistribution forces;
  };
  std::optional<grasping::GraspPlan> plan(const Executor& robot, const PickState& state,
                                          const std::vector<double>& tried_yaws) const;
  Hold close_as_planned(Executor& robot, PickState& state, const grasping::GraspPlan& plan) const;
  PhaseEnd grasp_unplanned(Executor& robot, PickState& state);
  PhaseEnd end(const Executor& robot, const Hold& hold, std::string_view grasp) const;
  void approach(Executor& robot, const grasping::GraspPlan& plan, double clear_height) const;
  void approach_from_side(Executor& robot, const PickState& state) const;
  void approach_from_above(Executor& robot, PickState& state) const;
  void descend(Executor& robot, const PickState& state) const;
  void travel_to(Executor& robot, const hand::MountPosition& start, const hand::Preshape& preshape,
                 double clear_height) const;
  void close(Executor& robot, const Closing& how) const;
  PhaseEnd held_up(const Executor& robot) const;
  Hold balance(const Executor& robot, const PickState& state) const;
  void press(Executor& robot, const Hold& hold) const;
  void release(Executor& robot) const;

  GraspOptions options_;
  const geometry::ObjectModel& object_;
  GraspChooser choose_;
};

}  // namespace palpate::skills
