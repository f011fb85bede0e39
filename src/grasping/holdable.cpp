// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/holdable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::grasping {
namespace {

constexpr std::size_t kPoints = 2000;  // of the surface
constexpr double kMaxUpward = 0.7;     // most of a normal's upward part, of one that looks sideways
constexpr double kInside = 1e-5;       // m below the surface, where the way through begins
constexpr double kFar = 10;            // m
constexpr double kNarrow = 0.5;        // of the opening: what is narrower is not too wide
constexpr double kNoBalance = 1;       // cost of a grasp whose forces balance nothing
constexpr double kBalance = 0.5;       // of one that is held by pressing harder
constexpr double kRare = 0.01;         // probability of a stable pose that is not looked at
constexpr double kRoughest = 1;        // friction of a fingertip on anything
constexpr double kClosingRate = 1;     // rad/s; any has its path

Eigen::Vector3d tip_of(const hand::Description& hand, const hand::ActuatorVector& posture,
                       std::size_t finger) {
  const auto T_mount_link =
      hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, posture));
  return T_mount_link[static_cast<std::size_t>(hand.fingers[finger].link)] *
         hand.fingers[finger].tip.b;
}

double opening_of(const hand::Description& hand, const hand::ActuatorVector& posture) {
  const auto thumb = static_cast<std::size_t>(hand.thumb);
  const Eigen::Vector3d p_thumb = tip_of(hand, posture, thumb);
  double widest = 0;
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    if (finger == thumb) continue;
    const double radii = hand.fingers[finger].tip.radius + hand.fingers[thumb].tip.radius;
    widest = std::max(widest, (tip_of(hand, posture, finger) - p_thumb).norm() - radii);
  }
  return widest;
}

double press_of(const hand::Description& hand, int finger) {
  double force = std::numeric_limits<double>::infinity();
  for (const int i : hand::closing_actuators(hand, finger)) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    force = std::min(force, actuator.max_torque / actuator.lever);
  }
  return std::isfinite(force) ? force : 0;
}

bool sideways_in_any(const geometry::KnownObject& object, const Eigen::Vector3d& normal) {
  return std::any_of(object.stable_poses.begin(), object.stable_poses.end(),
                     [&](const geometry::StablePose& stable_pose) {
                       const double up = stable_pose.R_table_object.row(2) * normal;
                       return std::abs(up) < kMaxUpward;
                     });
}

/// Whether some grasp from above holds it in a stable pose, even though badly.
/// @param press  N of all fingertips together
/// @param most  of its cost
bool has_grasp(const geometry::ObjectModel& object, const geometry::StablePose& stable_pose,
               const hand::Description& hand, double press, double most) {
  Eigen::Isometry3d T_table_object(stable_pose.R_table_object);
  T_table_object.translation().z() = stable_pose.height;
  const hand::Preshape& preshape = hand.postures.top;
  const auto path =
      closing_trajectory(hand, preshape.open, ClosingLaw(hand, kClosingRate, preshape.closed));
  GraspPlanOptions options;
  options.press = press;
  return std::any_of(
      preshape.attitudes.begin(), preshape.attitudes.end(), [&](const hand::Attitude& attitude) {
        const auto plan = plan_grasp(object, T_table_object, path, attitude, options);
        return plan && plan->cost < most;
      });
}

bool has_grasp(const geometry::ObjectModel& object, const hand::Description& hand, double press,
               double most) {
  const auto& stable_poses = object.object().stable_poses;
  return std::any_of(stable_poses.begin(), stable_poses.end(), [&](const auto& stable_pose) {
    return stable_pose.probability > kRare && has_grasp(object, stable_pose, hand, press, most);
  });
}

/// What is heavy needs to be pressed harder than a plan assumes by itself.
bool has_grasp(const geometry::ObjectModel& object, const hand::Description& hand, double press) {
  const double usual = GraspPlanOptions{}.press;
  return has_grasp(object, hand, usual, kNoBalance) ||
         (press > usual && has_grasp(object, hand, press, kBalance));
}

}  // namespace

double opening(const hand::Description& hand) {
  return std::max(opening_of(hand, hand.postures.top.open),
                  opening_of(hand, hand.postures.side.open));
}

double greatest_press(const hand::Description& hand) {
  double others = 0;
  for (int finger = 0; finger < static_cast<int>(hand.fingers.size()); ++finger) {
    if (finger != hand.thumb) others += press_of(hand, finger);
  }
  return 2 * std::min(press_of(hand, hand.thumb), others);
}

double min_width(const geometry::KnownObject& object) {
  const geometry::MeshQuery query(object.mesh);
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [point, normal] :
       geometry::sample_surface(object.mesh, kPoints, RandomStream(0, "least width"))) {
    if (!sideways_in_any(object, normal)) continue;
    const auto hit = query.raycast(point - kInside * normal, -normal, kFar);
    if (hit) least = std::min(least, hit->distance + kInside);
  }
  return least;
}

std::string why_not_holdable(const geometry::ObjectModel& object, const hand::Description& hand,
                             double press) {
  if (hand.links.empty()) {
    throw BadInput(
        fmt::format("the hand {:?} has no links, so that its grasps are not known", hand.name));
  }
  const double weight = object.object().mass * kGravity, most = greatest_press(hand);
  if (weight > kRoughest * most) {
    return fmt::format("too heavy: it weighs {:.1f} N, and the fingers press with {:.0f} N", weight,
                       most);
  }
  const double width = min_width(object.object()), open = opening(hand);
  if (width > kNarrow * open && !has_grasp(object, hand, std::min(press, most))) {
    return fmt::format("too wide: {:.0f} mm across at least, and the hand opens {:.0f} mm",
                       1e3 * width, 1e3 * open);
  }
  return {};
}

}  // namespace palpate::grasping
