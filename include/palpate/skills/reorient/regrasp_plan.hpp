// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/skills/place_strategy.hpp"

namespace palpate::skills {

/// The hand as the search sees it: how it closes, and at which attitudes it comes down.
struct GraspTool {
  grasping::ClosingTrajectory path;
  std::vector<hand::Attitude> attitudes;  ///< of the mount
  /// Whether what carries the hand can bring it to a grasp, and, holding the object, to where it
  /// lets go; empty: everywhere.
  std::function<bool(const hand::MountPosition&)> reaches = {}, releases = {};
};

/// The tool of the grasps from above, at the attitudes from which an object can then be turned far.
GraspTool regrasp_tool(const hand::Description& hand);

/// A hand that holds the object already.
struct Holding {
  hand::MountPosition mount;
  hand::JointVector joints;                         ///< rad
  Eigen::Vector3d away = Eigen::Vector3d::UnitZ();  ///< unit, mount's frame: where it came from
};

/// A coarser search for grasps than where only one is wanted.
inline grasping::GraspPlanOptions many_grasps() {
  grasping::GraspPlanOptions options;
  options.yaws = 16;
  options.places = 2;
  options.spacing = 0.014;
  return options;
}

struct RegraspOptions {
  /// Of the hand from the table where it lets go, m: the spheres that stand for the forearm fall
  /// 11 mm short of its corners.
  double clearance = 0.016;
  double retreat = 0.10;         ///< by which the opened hand then rises, free of the object, m
  double worst_grasp = 0.6;      ///< largest cost of a grasp that is used
  double transfer_cost = 1.0;    ///< of picking up and putting down
  double turn_cost = 0.1;        ///< of a radian by which the hand turns while it holds
  double rare_cost = 0.3;        ///< of a stable pose in between, times its improbability
  int max_transfers = 3;         ///< on one way
  double done_angle = 0.02;      ///< rad from the target that need no motion
  double done_distance = 0.002;  ///< m
  grasping::GraspPlanOptions grasp = many_grasps();

  template <class Visitor>
  void visit(Visitor&& v) {
    v.expert("clearance", clearance, 0.0, 0.1,
             "m, distance of the hand from the table where it releases the object");
    v.expert("retreat", retreat, 0.0, 0.5, "m, rise of the opened hand after the release");
    v.expert("worst_grasp", worst_grasp, 0.0, 2.0, "largest cost of a grasp that is used");
    v.expert("transfer_cost", transfer_cost, 0.01, 100.0, "cost of picking up and putting down");
    v.expert("turn_cost", turn_cost, 0.0, 10.0,
             "cost of turning the hand by 1 rad while it holds the object");
    v.expert("rare_cost", rare_cost, 0.0, 10.0,
             "cost of a stable pose on the way, times its improbability");
    v("max_transfers", max_transfers, 1, 10, "number of transfers in one plan at most");
    v.expert("done_angle", done_angle, 0.0, 0.5,
             "rad, distance from the target below which no motion is planned");
    v.expert("done_distance", done_distance, 0.0, 0.1,
             "m, distance from the target below which no motion is planned");
    v.expert_section("grasp", grasp);
  }
};

/// A lighter hold on certainty than where the object is to stay: between two stable poses a wrong
/// guess is detected after the next transfer.
struct RegraspSequenceOptions {
  int rounds = 8;                ///< transfers tried at most, repeated ones included
  double certain_between = 0.5;  ///< PlaceOptions::certain of all transfers but the last
  RegraspOptions plan;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("rounds", rounds, 1, 100, "number of transfers at most, repeated ones included");
    v("certain_between", certain_between, 0.0, 1.0,
      "certainty required for all transfers but the last");
    v.section("plan", plan);
  }
};

/// The object is picked up once and put down once.
struct Transfer {
  int from = -1, to = -1;  ///< indices into KnownObject::stable_poses; -1: the start, the target
  std::optional<grasping::GraspPlan> grasp;  ///< none: the hand holds the object already
  Eigen::Isometry3d T_world_from = Eigen::Isometry3d::Identity();  ///< the object's poses
  Eigen::Isometry3d T_world_to = Eigen::Isometry3d::Identity();
  hand::MountPosition release;  ///< mount where the hand lets go
  double turn = 0;              ///< rad, by which the hand turns while it holds
  double clearance = 0;         ///< m, of the hand from the table where it lets go and withdraws
  double cost = 0;
};

/// Why a strategy was chosen or not.
struct StrategyReport {
  PlaceStrategy strategy = PlaceStrategy::none;
  bool possible = false;
  std::string reason;
};

struct RegraspPlan {
  bool found = false;
  PlaceStrategy strategy = PlaceStrategy::none;
  std::vector<Transfer> transfers;  ///< in order; empty for PlaceStrategy::none or without a way
  double cost = 0;                  ///< of all transfers
  /// Cheapest strategy first; those not looked at are missing.
  std::vector<StrategyReport> considered;
  int grasps = 0;      ///< that were examined
  double seconds = 0;  ///< wall time
};

/// How to get a resting or held object into another pose on the table: the cheapest chain of
/// transfers between its stable poses.
///
/// A graph (as Lozano-Perez' and Tournassoud's regrasping): its nodes are the start, the object's
/// stable poses up to symmetry, and the target; an edge is a grasp in one pose by which the object
/// can be put down in the other so that neither the closed hand nor the opened one, withdrawing the
/// way it came, meets the table. The hand's mount turns freely. Searched best first (A*, whose
/// bound is one transfer), so that grasps are only sought in stable poses that are worth it.
/// Deterministic.
/// @param holding  of a hand that holds the object at T_world_object
/// @throws BadInput for poses that are not finite, or a target inside the table
RegraspPlan plan_regrasp(const geometry::ObjectModel& object, const hand::Description& hand,
                         const GraspTool& tool, const Eigen::Isometry3d& T_world_object,
                         const Eigen::Isometry3d& T_world_target, const RegraspOptions& options,
                         const std::optional<Holding>& holding = {});

}  // namespace palpate::skills
