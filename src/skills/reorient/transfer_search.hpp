// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include "palpate/skills/reorient/regrasp_plan.hpp"

namespace palpate::skills {

/// A way to hold the object, and the room that the hand takes up.
struct Hold {
  std::optional<grasping::GraspPlan> grasp;  ///< none: the hand holds it already
  hand::MountPosition mount;
  Eigen::Isometry3d T_mount_object = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector4f> spheres;   ///< mount's frame: closed, but for the fingers' ways
  mutable std::optional<bool> reachable;  ///< whether the hand can be brought there, once asked
};

/// The grasps of an object at rest that are good enough.
std::vector<Hold> holds_of(const geometry::ObjectModel& object, const GraspTool& tool,
                           const Eigen::Isometry3d& T_world_object, const RegraspOptions& options);

/// That of a hand that holds the object.
Hold hold_of(const hand::Description& hand, const Holding& holding,
             const Eigen::Isometry3d& T_world_object);

/// Looks for the cheapest hold by which the object can be put down in a pose.
class TransferSearch {
 public:
  TransferSearch(const geometry::ObjectModel& object, const GraspTool& tool,
                 const RegraspOptions& options, const Eigen::Isometry3d& T_world_from)
      : object_(object), tool_(tool), options_(options), from_(T_world_from) {}

  /// The pose, or with a free yaw that which needs the least turn; always one that the object's
  /// symmetries allow.
  void set_goal(const Eigen::Isometry3d& T_world_to, bool free_yaw);

  /// @param from_start  whether the poses are where the object is and will be, so that the hand has
  ///        to reach them
  std::optional<Transfer> cheapest(const std::vector<Hold>& holds, bool from_start);

  /// Largest of the holds' clearances, m.
  [[nodiscard]] double largest_clearance() const { return largest_clearance_; }
  /// Whether there is a hold, but none to which and with which the hand can be brought.
  [[nodiscard]] bool out_of_reach() const { return out_of_reach_; }

 private:
  struct Choice {
    const Hold* hold;
    double clearance, cost;
  };
  double clearance(const Hold& hold) const;
  bool rises_freely(const Hold& hold) const;
  bool reachable(const Choice& choice) const;
  hand::MountPosition release(const Hold& hold) const;
  Transfer transfer(const Choice& choice) const;
  double cost(const Hold& hold) const;

  const geometry::ObjectModel& object_;
  const GraspTool& tool_;
  const RegraspOptions& options_;
  Eigen::Isometry3d from_, to_ = Eigen::Isometry3d::Identity();
  double turn_ = 0;
  double largest_clearance_ = -std::numeric_limits<double>::infinity();
  bool out_of_reach_ = false;
};

}  // namespace palpate::skills
