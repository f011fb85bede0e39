// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/hand/closing.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::pipeline {

/// Points of one finger, in the base's frame, at one instant of its closing.
struct FingerShape {
  std::vector<Eigen::Vector3f> tip;            ///< on the axis of the fingertip's capsule
  std::vector<Eigen::Vector4f> other_spheres;  ///< of its other links: center and radius
};

/// How an empty hand closes: the shapes that its fingers pass through.
struct ClosingPath {
  std::vector<Eigen::Vector4f> open_spheres;  ///< of the whole hand before closing
  std::array<std::vector<FingerShape>, hand::kFingers> fingers;
  std::array<float, hand::kFingers> tip_radius{};
};

/// @param law  of the closing; its rates say how the joints move in proportion
ClosingPath closing_path(const hand::HandModel& hand, const hand::ActuatorVector& open,
                         const hand::ClosingLaw& law);

struct PlanOptions {
  double clearance = 0.004;        ///< of the opened hand from the object, m
  double table_clearance = 0.005;  ///< of the hand from the table, m
  double press = 6.0;              ///< N, of all fingertips together
  double friction = 0.4;           ///< that the balance of forces counts on
  double missing_finger = 0.05;    ///< cost of a finger that does not meet the object
  double pose_error = 0.004;       ///< m by which the object may lie elsewhere

  template <class Visitor>
  void visit(Visitor&& v) {
    v("clearance", clearance, 0.0, 0.02, "m, of the opened hand from the object");
    v("table_clearance", table_clearance, 0.0, 0.05, "m, of the hand from the table");
    v("press", press, 0.1, 100.0, "N, of all fingertips together");
    v("friction", friction, 0.0, 2.0, "that the balance of forces counts on");
    v("missing_finger", missing_finger, 0.0, 1.0, "cost of a finger that does not meet the object");
    v("pose_error", pose_error, 0.0, 0.05, "m by which the object may lie elsewhere");
  }
};

/// Where the hand is to close, and how well the fingers should then hold the object.
struct GraspPlan {
  hand::BasePosition base;
  double cost = 0;  ///< mean over small displacements of the object
  int fingers = 0;  ///< that meet the object
};

/// Closes the hand in thought, at many places around the object's pose, and takes the one where the
/// fingertips' forces balance best, together with the weight. The opened hand must come down there
/// without touching the object.
///
/// @param attitude  pitch and roll of the base, rad
/// @param avoid  yaws of the base (rad) that have failed before
/// @return nothing if no place will do
std::optional<GraspPlan> plan_grasp(const localization::ObjectModel& object,
                                    const Eigen::Isometry3d& T_world_object,
                                    const ClosingPath& path, const Eigen::Vector2d& attitude,
                                    const PlanOptions& options,
                                    const std::vector<double>& avoid = {});

}  // namespace palpate::pipeline
