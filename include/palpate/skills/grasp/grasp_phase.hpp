// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>

#include "palpate/grasping/closing_law.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

/// How the hand comes to the object and closes: one set for grasps from the side, one from above.
struct Preshape {
  double pitch, roll;            ///< of the base, rad
  double offset_x, offset_y;     ///< of the base from the object's place, hand's axes, m
  double height;                 ///< of the base above the table (side grasp), m
  double approach_speed = 0.10;  ///< m/s
  double contact_load;           ///< N on the base that ends the approach
  double push;                   ///< m to go on after that
  double thumb_base, thumb_opposition, thumb_middle;  ///< THJ5, THJ4, THJ2, rad
  double proximal, distal, spread, little_base;       ///< J3, J0, -FFJ4 and -LFJ4, LFJ5, rad
  double closing_rate;                                ///< of J3, rad/s
  double thumb_limit;                                 ///< largest THJ5, rad
  grasping::ClosingTorque contact_torque;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("pitch", pitch, -1.6, 1.6, "rad, of the base");
    v("roll", roll, -3.2, 3.2, "rad, of the base");
    v("offset_x", offset_x, -0.2, 0.2, "m, base ahead of the object's place");
    v("offset_y", offset_y, -0.2, 0.2, "m, base to the left of the object's place");
    v("height", height, 0.0, 0.3, "m, of the base above the table (side grasp)");
    v("approach_speed", approach_speed, 0.001, 0.5, "m/s");
    v("contact_load", contact_load, 0.05, 50.0, "N on the base that ends the approach");
    v("push", push, 0.0, 0.1, "m to go on after the touch");
    v("thumb_base", thumb_base, -1.05, 1.05, "rad, THJ5 before closing");
    v("thumb_opposition", thumb_opposition, 0.0, 1.23, "rad, THJ4");
    v("thumb_middle", thumb_middle, -0.7, 0.7, "rad, THJ2 before closing");
    v("proximal", proximal, -0.27, 1.58, "rad, J3 before closing");
    v("distal", distal, 0.0, 3.15, "rad, J0 before closing");
    v("spread", spread, -0.35, 0.35, "rad, of first and little finger to the outside");
    v("little_base", little_base, 0.0, 0.79, "rad, LFJ5");
    v("closing_rate", closing_rate, 0.01, 20.0, "rad/s, of J3");
    v("thumb_limit", thumb_limit, -1.05, 1.05, "rad, largest THJ5");
    v.section("contact_torque", contact_torque);
  }
};

Preshape side_preshape();
Preshape top_preshape();

/// The fingers as they are before they close.
hand::ActuatorVector open_posture(const Preshape& preshape);

struct GraspOptions {
  double side_from = 0.3;  ///< objects at least this tall are grasped from the side, m
  Preshape side = side_preshape();
  Preshape top = top_preshape();
  int turns = 4;                  ///< directions tried from above when fingers land on the object
  double min_depth = 0.02;        ///< m below the object's top that the fingers must reach
  double travel_speed = 0.5;      ///< m/s
  double longest_close = 8.0;     ///< s until all fingers have met the object
  double ramp_seconds = 0.8;      ///< from touching to pressing
  double press_per_weight = 3.0;  ///< of all fingertips together, by the object's weight
  double min_press = 5.0;         ///< N
  double steep_pitch = 0.9;       ///< rad, of the base where the usual one does not do
  double good_cost = 0.1;         ///< of a plan with which the search ends
  grasping::PlanOptions plan;
  double friction = 0.5;             ///< that the balance of forces counts on
  int closings = 3;                  ///< from other sides, at most, until the forces balance
  double max_wrench_residual = 0.3;  ///< of the forces with which the fingers would press
  int min_contacts = 2;              ///< fingertip contacts that count as a grasp

  template <class Visitor>
  void visit(Visitor&& v) {
    v("side_from", side_from, 0.0, 0.5, "m, objects at least this tall are grasped from the side");
    v.expert("turns", turns, 1, 36, "directions tried from above when fingers land on the object");
    v.expert("min_depth", min_depth, 0.0, 0.2,
             "m below the object's top that the fingers must reach");
    v.expert("travel_speed", travel_speed, 0.01, 2.0, "m/s, through the air");
    v.expert("longest_close", longest_close, 0.1, 30.0, "s until all fingers have met the object");
    v.expert("ramp_seconds", ramp_seconds, 0.01, 10.0, "s, from touching to pressing");
    v("press_per_weight", press_per_weight, 0.0, 100.0, "of all fingertips, by the weight");
    v.expert("steep_pitch", steep_pitch, -1.6, 1.6,
             "rad, of the base where the usual one does not do");
    v.expert("good_cost", good_cost, 0.0, 2.0, "of a plan with which the search ends");
    v("min_press", min_press, 0.1, 100.0, "N, of all fingertips together");
    v("closings", closings, 1, 20, "from other sides, until the forces balance");
    v("max_wrench_residual", max_wrench_residual, 0.0, 10.0,
      "of the forces with which the fingers would press");
    v("min_contacts", min_contacts, 0, 20, "fingertip contacts that count as a grasp");
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
  /// What the closed fingers feel, and the forces with which they are to press.
  struct Hold {
    std::vector<tactile::Contact> contacts;
    grasping::ForceDistribution forces;
  };
  std::optional<grasping::GraspPlan> plan(const Executor& robot, const PickState& state,
                                          const std::vector<double>& tried_yaws) const;
  Hold close_as_planned(Executor& robot, PickState& state, const grasping::GraspPlan& plan) const;
  PhaseEnd grasp_unplanned(Executor& robot, PickState& state);
  PhaseEnd end(const Executor& robot, const Hold& hold, std::string_view grasp) const;
  void approach(Executor& robot, const grasping::GraspPlan& plan) const;
  void approach_from_side(Executor& robot, const PickState& state) const;
  void approach_from_above(Executor& robot, PickState& state) const;
  void descend(Executor& robot, const PickState& state) const;
  void travel_to(Executor& robot, const hand::BasePosition& start, const Preshape& preshape) const;
  void close(Executor& robot, const Preshape& preshape) const;
  Hold balance(const Executor& robot, const PickState& state) const;
  void press(Executor& robot, const Hold& hold) const;
  void let_go(Executor& robot) const;

  GraspOptions options_;
  const geometry::ObjectModel& object_;
  GraspChooser choose_;
};

}  // namespace palpate::skills
