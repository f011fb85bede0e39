// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/grasping/closing_trajectory.hpp"

namespace palpate::grasping {

/// Share of the believed friction that forces count on where the object may still move in the hand.
inline constexpr double kPlannedShare = 0.8;

struct GraspPlanOptions {
  double clearance = 0.004;        ///< of the opened hand from the object, m
  double table_clearance = 0.005;  ///< of the hand from the table, m
  double press = 6.0;              ///< N, of all fingertips together; whoever plans sets it
  double friction = 0.4;           ///< that the balance of forces counts on
  double missing_finger = 0.05;    ///< cost of a finger that does not meet the object
  double pose_error = 0.004;       ///< m by which the object may lie elsewhere
  int yaws = 24;                   ///< of the hand that are tried
  int places = 3;                  ///< that are tried to either side of the middle
  double spacing = 0.010;          ///< m between them

  template <class Visitor>
  void visit(Visitor&& v) {
    v("clearance", clearance, 0.0, 0.02, "m, distance of the opened hand from the object");
    v("table_clearance", table_clearance, 0.0, 0.05, "m, distance of the hand from the table");
    v("missing_finger", missing_finger, 0.0, 1.0, "cost of a finger that does not meet the object");
    v("pose_error", pose_error, 0.0, 0.05,
      "m, displacement of the object for which a grasp is checked");
    v("yaws", yaws, 1, 360, "number of yaws of the hand that are tried");
    v("places", places, 0, 20,
      "number of positions of the hand that are tried to either side of the object's middle");
    v("spacing", spacing, 0.001, 0.1, "m, distance between these positions");
  }
};

/// Where the hand is to close, and how well the fingers should then hold the object.
struct GraspPlan {
  hand::MountPosition mount;
  double cost = 0;           ///< mean over small displacements of the object
  double expected_cost = 0;  ///< the same, and over all poses that the object may have
  int fingers = 0;           ///< that meet the object
  int missing = 0;           ///< fingers that do not
  std::vector<tactile::Contact> contacts;  ///< of their tips, in the mount's frame
  hand::PerFinger<std::size_t> stops{};    ///< shape of its path where each finger ends
};

/// A pose that the object may have.
struct PossiblePose {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  double weight = 1;
};

/// How the hand closes at a place; of infinite cost if its thumb and another finger do not both
/// meet the object.
/// @return nothing where the opened hand cannot come down freely
std::optional<GraspPlan> close_virtually(const geometry::ObjectModel& object,
                                         const Eigen::Isometry3d& T_world_object,
                                         const ClosingTrajectory& path,
                                         const hand::MountPosition& mount,
                                         const GraspPlanOptions& options);

/// All places where the opened hand can come down freely and its thumb and another finger then meet
/// the object, in a fixed order. Their costs are for the object just where it is.
/// @param attitude  pitch and roll of the mount, rad
/// @param avoid  yaws of the mount (rad) that have failed before
std::vector<GraspPlan> find_grasps(const geometry::ObjectModel& object,
                                   const Eigen::Isometry3d& T_world_object,
                                   const ClosingTrajectory& path, const hand::Attitude& attitude,
                                   const GraspPlanOptions& options,
                                   const std::vector<double>& avoid = {});

/// Mean cost of a grasp over the displacements of GraspPlanOptions::pose_error.
double mean_cost(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object,
                 const ClosingTrajectory& path, const GraspPlanOptions& options,
                 const GraspPlan& plan);

/// Cost of a grasp of these contacts: how badly its forces balance when gravity pulls that way.
/// @param gravity  unit, in the mount's frame
/// @param p_mount_object  the object's centroid in the mount's frame, m
double grasp_cost(const geometry::ObjectModel& object, const GraspPlan& plan,
                  const GraspPlanOptions& options, const Eigen::Vector3d& gravity,
                  const Eigen::Vector3d& p_mount_object);

/// Closes the hand virtually, at many places around the object's pose, and takes the one where the
/// fingertips' forces balance best, together with the weight. The opened hand must come down there
/// without touching the object.
///
/// @param attitude  pitch and roll of the mount, rad
/// @param avoid  yaws of the mount (rad) that have failed before
/// @return nothing if no place will do
std::optional<GraspPlan> plan_grasp(const geometry::ObjectModel& object,
                                    const Eigen::Isometry3d& T_world_object,
                                    const ClosingTrajectory& path, const hand::Attitude& attitude,
                                    const GraspPlanOptions& options,
                                    const std::vector<double>& avoid = {});

/// The same for an object that may have one of several poses: the grasp for the first of them whose
/// expected cost over all is least. Only the first pose is displaced.
/// @param poses  the most probable one first; their weights need not sum to 1
/// @throws std::invalid_argument without poses, or if their weights are not positive
std::optional<GraspPlan> plan_grasp(const geometry::ObjectModel& object,
                                    const std::vector<PossiblePose>& poses,
                                    const ClosingTrajectory& path, const hand::Attitude& attitude,
                                    const GraspPlanOptions& options,
                                    const std::vector<double>& avoid = {});

}  // namespace palpate::grasping
