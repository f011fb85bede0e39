// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <string>

#include "palpate/planning/planner.hpp"
#include "palpate/skills/phase.hpp"
#include "palpate/skills/place/place_goal.hpp"

namespace palpate::skills {

/// A planner that is gentle with what hangs in the hand, and leaves the fingers alone.
inline planning::PlanOptions transport_plan_options() {
  planning::PlanOptions options;
  options.move_all = false;
  options.mount.turn = 4 * std::numbers::pi;  // picking may have gone round the object
  options.limits.mount_acceleration = 0.5;
  options.limits.turn_acceleration = 2.0;
  options.limits.turn_speed = 0.8;
  return options;
}

struct TransportOptions {
  planning::PlanOptions plan = transport_plan_options();
  double settle = 0.4;      ///< s of rest at the end
  double min_weight = 0.5;  ///< share of the load before that must still hang
  double max_slip = 0.012;  ///< m, of a fingertip's contact along the fingertip
  int lost_ticks = 10;      ///< without any touch: the object is lost
  bool bear_weight = true;  ///< the fingers' commands follow the weight as the hand turns
  double friction = 0.4;    ///< that the forces which bear it count on

  template <class Visitor>
  void visit(Visitor&& v) {
    v.expert_section("plan", plan);
    v.expert("settle", settle, 0.0, 10.0, "s, rest at the end of the transport");
    v.expert("min_weight", min_weight, 0.0, 1.0,
             "share of the load below which the object counts as lost");
    v.expert("max_slip", max_slip, 1e-3, 0.1, "m, largest motion of a contact along its fingertip");
    v.expert("lost_ticks", lost_ticks, 1, 1000,
             "number of ticks without any touch after which the object counts as lost");
    v("bear_weight", bear_weight,
      "adapt the fingers' commands to the direction of the weight as the hand turns");
  }
};

/// Carries the held object over its goal along a planned path that is free of collisions (thesis
/// section 2.2.1) for the hand and for the object at its ESTIMATED pose. Only the mount moves; the
/// fingers keep pressing, and bear the weight wherever it pulls as the hand turns. Where an arm
/// cannot follow straight lines, the path is planned in the space of its joints. Loss and slip are
/// noticed by touch and load.
class TransportPhase : public Phase {
 public:
  /// @param scene  with the held object in it
  TransportPhase(const TransportOptions& options, planning::CollisionChecker& scene,
                 const PlaceGoal& goal, std::uint64_t seed, std::string name = "transport")
      : options_(options), scene_(scene), goal_(goal), seed_(seed), name_(std::move(name)) {}
  std::string_view name() const override { return name_; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

  bool lost() const { return lost_; }
  /// The motion that was planned; empty samples if there was none.
  const planning::Plan& motion() const { return motion_; }
  /// The same, with the angles of a mount that an arm has brought there the other way round.
  const PlaceGoal& goal() const { return goal_; }

 private:
  planning::Plan planned(const Executor& robot, const hand::MountPosition& from,
                         const hand::MountPosition& yielded) const;
  std::vector<hand::HandCommand> commands(const Executor& robot,
                                          const hand::MountPosition& yielded) const;

  TransportOptions options_;
  planning::CollisionChecker& scene_;
  PlaceGoal goal_;
  std::uint64_t seed_;
  std::string name_;
  planning::Plan motion_;
  bool lost_ = false;
};

}  // namespace palpate::skills
