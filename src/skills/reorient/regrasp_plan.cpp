// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/reorient/regrasp_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "palpate/skills/resting_pose.hpp"
#include "skills/reorient/transfer_search.hpp"

namespace palpate::skills {
namespace {

constexpr double kSameStablePose = 0.06;  // rad between stable poses that are one
constexpr double kInsideTable = 0.003;    // m by which a target may be below the table
constexpr double kFineRate = 0.5;         // rad/s, of the closing whose path is planned with
constexpr int kStart = 0;                 // nodes: the start, the stable poses, the target

/// Direction in the object's frame that points up.
Eigen::Vector3d up_of(const Eigen::Matrix3d& R_world_object) {
  return R_world_object.row(2).transpose();
}

/// A pose the object rests in, up to yaw and place but for the start and the target.
struct Node {
  int stable_pose = -1;
  bool free_yaw = false;
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  double rare = 0;  ///< improbability of the stable pose
};

/// How a node has been reached.
struct Visit {
  double cost = std::numeric_limits<double>::infinity();
  std::size_t before = 0;
  int transfers = 0;
  std::optional<Transfer> transfer;
  bool expanded = false;
};

class Search {
 public:
  Search(const geometry::ObjectModel& object, const hand::Description& hand, const GraspTool& tool,
         const RegraspOptions& options)
      : object_(object), hand_(hand), tool_(tool), options_(options) {}

  RegraspPlan run(const Eigen::Isometry3d& start, const Eigen::Isometry3d& target,
                  const std::optional<Holding>& holding) {
    make_nodes(start, target);
    holding_ = holding;
    RegraspPlan plan;
    visits_.assign(nodes_.size(), {});
    visits_[kStart].cost = 0;
    while (const auto next = cheapest()) {
      if (*next + 1 == nodes_.size()) {
        plan.found = true;
        break;
      }
      expand(*next, plan);
    }
    if (plan.found) trace(plan);
    plan.strategy = plan.transfers.size() > 1 ? PlaceStrategy::regrasp : PlaceStrategy::wrist;
    explain(plan);
    return plan;
  }

 private:
  void make_nodes(const Eigen::Isometry3d& start, const Eigen::Isometry3d& target) {
    nodes_ = {{-1, false, start, 0}};
    std::vector<Eigen::Vector3d> ups;
    if (rests_in_a_stable_pose(start)) ups.push_back(up_of(start.linear()));
    const auto& stable_poses = object_.object().stable_poses;
    for (std::size_t i = 0; i < stable_poses.size(); ++i) {
      const Eigen::Vector3d up = up_of(stable_poses[i].R_table_object);
      if (std::any_of(ups.begin(), ups.end(), [&](const auto& u) { return same(u, up); })) continue;
      ups.push_back(up);
      nodes_.push_back({static_cast<int>(i), true,
                        resting_pose(object_.object(), i, start.translation().head<2>(), 0),
                        1 - stable_poses[i].probability});
    }
    nodes_.push_back({-1, false, target, 0});
  }

  bool same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    const auto& symmetries = object_.object().symmetries;
    return std::any_of(symmetries.begin(), symmetries.end(), [&](const Eigen::Matrix3d& S) {
      return (S * a - b).norm() < kSameStablePose;
    });
  }

  bool rests_in_a_stable_pose(const Eigen::Isometry3d& T) const {
    const auto& stable_poses = object_.object().stable_poses;
    return std::any_of(stable_poses.begin(), stable_poses.end(),
                       [&](const geometry::StablePose& stable_pose) {
                         return same(up_of(T.linear()), up_of(stable_pose.R_table_object));
                       });
  }

  /// Node that promises the cheapest way, not yet expanded; every node but the target is at least
  /// one transfer away from it.
  std::optional<std::size_t> cheapest() const {
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (visits_[i].expanded) continue;
      const double ahead = i + 1 == nodes_.size() ? 0 : options_.transfer_cost;
      if (visits_[i].cost + ahead >= least) continue;
      least = visits_[i].cost + ahead;
      best = i;
    }
    return best;
  }

  void expand(std::size_t index, RegraspPlan& plan) {
    visits_[index].expanded = true;
    if (visits_[index].transfers >= options_.max_transfers) return;
    const bool held = index == kStart && holding_;
    const auto holds =
        held ? std::vector<Hold>{hold_of(hand_, *holding_, nodes_[index].T_world_object)}
             : holds_of(object_, tool_, nodes_[index].T_world_object, options_);
    plan.grasps += held ? 0 : static_cast<int>(holds.size());
    for (std::size_t other = 1; other < nodes_.size(); ++other) {
      if (visits_[other].expanded) continue;
      connect(index, other, holds);
    }
    if (index == kStart) from_start_ = holds.size();
  }

  void connect(std::size_t from, std::size_t to, const std::vector<Hold>& holds) {
    TransferSearch search(object_, tool_, options_, nodes_[from].T_world_object);
    search.set_goal(nodes_[to].T_world_object, nodes_[to].free_yaw);
    auto transfer = search.cheapest(holds, from == kStart);
    if (from == kStart && to + 1 == nodes_.size()) {
      nearest_ = search.largest_clearance();
      out_of_reach_ = search.out_of_reach();
    }
    if (!transfer) return;
    transfer->from = nodes_[from].stable_pose;
    transfer->to = nodes_[to].stable_pose;
    transfer->cost += options_.rare_cost * nodes_[to].rare;
    const double cost = visits_[from].cost + transfer->cost;
    if (cost >= visits_[to].cost) return;
    visits_[to] = {cost, from, visits_[from].transfers + 1, std::move(transfer), false};
  }

  /// Nodes with a free yaw were searched at yaw 0; on the way they have that in which the transfer
  /// before leaves the object.
  void trace(RegraspPlan& plan) const {
    for (std::size_t i = nodes_.size() - 1; i != kStart; i = visits_[i].before) {
      plan.transfers.insert(plan.transfers.begin(), *visits_[i].transfer);
    }
    plan.cost = visits_.back().cost;
    Eigen::Isometry3d turned = Eigen::Isometry3d::Identity();
    for (std::size_t k = 1; k < plan.transfers.size(); ++k) {
      Transfer& transfer = plan.transfers[k];
      const Eigen::Isometry3d at = plan.transfers[k - 1].T_world_to;
      turned = at * transfer.T_world_from.inverse();
      transfer.grasp->mount =
          hand::nearest_mount(turned * transfer.grasp->mount.pose(), transfer.grasp->mount);
      const bool last = k + 1 == plan.transfers.size();
      if (!last) {
        transfer.T_world_to = turned * transfer.T_world_to;
        transfer.release = hand::nearest_mount(turned * transfer.release.pose(), transfer.release);
      }
      transfer.T_world_from = at;
      transfer.turn = rotation_distance(transfer.T_world_to.linear(), at.linear());
    }
  }

  void explain(RegraspPlan& plan) const {
    const bool one_hold = plan.found && plan.strategy == PlaceStrategy::wrist;
    plan.considered.push_back({PlaceStrategy::wrist, one_hold, why_one_hold(plan, one_hold)});
    if (one_hold) return;
    std::string way;
    for (const auto& t : plan.transfers)
      way += t.to >= 0 ? fmt::format(" stable pose {},", t.to) : "";
    plan.considered.push_back(
        {PlaceStrategy::regrasp, plan.found,
         plan.found ? fmt::format("over{} {} transfers, cost {:.2f}", way, plan.transfers.size(),
                                  plan.cost)
                    : fmt::format("no chain of at most {} transfers leads to the target",
                                  options_.max_transfers)});
  }

  std::string why_one_hold(const RegraspPlan& plan, bool one_hold) const {
    if (one_hold) {
      const Transfer& t = plan.transfers.front();
      return fmt::format("turned by {:.0f} deg, the hand stays {:.0f} mm above the table",
                         t.turn * 180 / std::numbers::pi, 1e3 * t.clearance);
    }
    if (from_start_ == 0) return "no grasp holds the object where it is";
    if (nearest_ < options_.clearance) {
      return fmt::format("of {} grasps the best would put the hand {:.0f} mm above the table",
                         from_start_, 1e3 * nearest_);
    }
    if (out_of_reach_) return "what carries the hand cannot bring it there as it would hold";
    return "a way over other stable poses costs less";
  }

  const geometry::ObjectModel& object_;
  const hand::Description& hand_;
  const GraspTool& tool_;
  const RegraspOptions& options_;
  std::optional<Holding> holding_;
  std::vector<Node> nodes_;
  std::vector<Visit> visits_;
  std::size_t from_start_ = 0;                                 // grasps there
  double nearest_ = -std::numeric_limits<double>::infinity();  // clearance at the target, m
  bool out_of_reach_ = false;                                  // grasps there, with the target
};

void check(const geometry::ObjectModel& object, const Eigen::Isometry3d& start,
           const Eigen::Isometry3d& target) {
  if (!start.matrix().allFinite() || !target.matrix().allFinite()) {
    throw BadInput("a pose to be regrasped from or to has a value that is not finite");
  }
  const double low = geometry::lowest_point(target, object.object().mesh);
  if (low < -kInsideTable) {
    throw BadInput(fmt::format("the target is {:.0f} mm inside the table", -1e3 * low));
  }
}

}  // namespace

GraspTool regrasp_tool(const hand::Description& hand) {
  const hand::Preshape& preshape = hand.postures.top;
  const grasping::ClosingLaw law(hand, kFineRate, preshape.closed);
  GraspTool tool{grasping::closing_trajectory(hand, preshape.open, law), preshape.attitudes};
  const auto& far = hand.postures.far_attitudes;
  tool.attitudes.insert(tool.attitudes.end(), far.begin(), far.end());
  return tool;
}

RegraspPlan plan_regrasp(const geometry::ObjectModel& object, const hand::Description& hand,
                         const GraspTool& tool, const Eigen::Isometry3d& T_world_object,
                         const Eigen::Isometry3d& T_world_target, const RegraspOptions& options,
                         const std::optional<Holding>& holding) {
  const auto begin = std::chrono::steady_clock::now();
  check(object, T_world_object, T_world_target);
  const auto error =
      localization::pose_error(T_world_object, T_world_target, object.object().symmetries);
  RegraspPlan plan;
  if (!holding && error.rotation < options.done_angle &&
      error.translation < options.done_distance) {
    plan.found = true;
    plan.considered.push_back({PlaceStrategy::none, true, "the object is there"});
  } else {
    plan = Search(object, hand, tool, options).run(T_world_object, T_world_target, holding);
  }
  plan.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return plan;
}

}  // namespace palpate::skills
