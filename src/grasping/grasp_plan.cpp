// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/grasp_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "palpate/core/gravity.hpp"
#include "palpate/grasping/force_distribution.hpp"

namespace palpate::grasping {
namespace {

using std::numbers::pi;

constexpr float kCommonWidth = 0.06f;       // m
constexpr std::size_t kFinalists = 16;      // that are looked at more closely
constexpr std::size_t kMoreFinalists = 64;  // where the object may have several poses
constexpr double kNoGrasp = 1.5;            // cost where the hand holds nothing
constexpr double kTurnedAway = 0.35;        // rad between a yaw and those that have failed
const std::array<double, 7> kHeights = {0, 0.012, 0.024, 0.036, 0.05, 0.065, 0.08};  // m
const std::array<float, 5> kDescent = {0, 0.01f, 0.03f, 0.06f, 0.1f};                // m

bool comes_down_freely(const PlacedObject& target, const ClosingTrajectory& path,
                       const GraspPlanOptions& options, const Eigen::Vector3f& up) {
  const auto clearance = static_cast<float>(options.clearance);
  for (const auto& sphere : path.open_spheres) {
    if (target.height(sphere.head<3>()) - sphere.w() < options.table_clearance) return false;
    for (const float raised : kDescent) {
      if (target.distance(sphere.head<3>() + raised * up) < sphere.w() + clearance) return false;
    }
  }
  return true;
}

/// A place to close, with the object where it is thought to lie.
class Candidate {
 public:
  Candidate(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object,
            const hand::MountPosition& mount)
      : object_(object),
        T_world_object_(T_world_object),
        mount_(mount),
        T_world_mount_(mount.pose()),
        target_(object, T_world_object, T_world_mount_) {}

  bool free(const ClosingTrajectory& path, const GraspPlanOptions& options) const {
    const Eigen::Vector3d up = T_world_mount_.linear().row(2).transpose();
    return comes_down_freely(target_, path, options, up.cast<float>());
  }

  GraspPlan evaluate(const ClosingTrajectory& path, const GraspPlanOptions& options) const {
    GraspPlan plan;
    plan.mount = mount_;
    plan.cost = std::numeric_limits<double>::infinity();
    for (std::size_t finger = 0; finger < path.fingers.size(); ++finger) {
      auto [stop, contact] = meet(target_, path, finger, options.table_clearance / 2);
      plan.stops[finger] = stop;
      if (!contact) continue;
      plan.contacts.push_back(*contact);
    }
    plan.fingers = static_cast<int>(plan.contacts.size());
    const bool thumb = std::any_of(plan.contacts.begin(), plan.contacts.end(),
                                   [&](const tactile::Contact& contact) {
                                     return contact.finger == static_cast<int>(path.thumb);
                                   });
    plan.missing = static_cast<int>(path.fingers.size()) - plan.fingers;
    if (!thumb || plan.fingers < 2) return plan;
    plan.cost = grasp_cost(object_, plan, options, -T_world_mount_.linear().row(2).transpose(),
                           T_world_mount_.inverse() * T_world_object_.translation());
    return plan;
  }

 private:
  const geometry::ObjectModel& object_;
  Eigen::Isometry3d T_world_object_;
  hand::MountPosition mount_;
  Eigen::Isometry3d T_world_mount_;
  PlacedObject target_;
};

/// Where thumb and fingers meet, in the mount's frame: between the tips when they have closed to
/// the width of a common object.
Eigen::Vector3d closing_center(const ClosingTrajectory& path) {
  const auto& thumb = path.fingers[path.thumb];
  const auto& middle = path.fingers[path.middle];
  std::size_t step = 0;
  while (step + 1 < thumb.size() &&
         (thumb[step].tip.back() - middle[step].tip.back()).norm() > kCommonWidth) {
    ++step;
  }
  return (0.5f * (thumb[step].tip.back() + middle[step].tip.back())).cast<double>();
}

double lowest_below_mount(const ClosingTrajectory& path, const Eigen::Matrix3d& R_world_mount) {
  double lowest = 0;
  for (const auto& sphere : path.open_spheres) {
    lowest = std::min(lowest, R_world_mount.row(2).dot(sphere.head<3>().cast<double>()) -
                                  static_cast<double>(sphere.w()));
  }
  return lowest;
}

bool was_tried(double yaw, const std::vector<double>& avoid) {
  return std::any_of(avoid.begin(), avoid.end(), [&](double tried) {
    return std::abs(std::remainder(yaw - tried, 2 * pi)) < kTurnedAway;
  });
}

std::vector<hand::MountPosition> places(const ClosingTrajectory& path,
                                        const Eigen::Vector3d& centroid,
                                        const hand::Attitude& attitude,
                                        const GraspPlanOptions& options,
                                        const std::vector<double>& avoid) {
  std::vector<hand::MountPosition> result;
  const Eigen::Vector3d center = closing_center(path);
  for (int i = 0; i < options.yaws; ++i) {
    hand::MountPosition mount;
    mount.ypr = {2 * pi * i / options.yaws, attitude.pitch, attitude.roll};
    if (was_tried(mount.ypr.x(), avoid)) continue;
    const Eigen::Matrix3d R = mount.pose().linear();
    const double low = options.table_clearance + 0.001 - lowest_below_mount(path, R);
    const Eigen::Vector2d middle = (centroid - R * center).head<2>();
    const Eigen::Rotation2Dd turn(mount.ypr.x());
    for (const double raised : kHeights) {
      for (int x = -options.places; x <= options.places; ++x) {
        for (int y = -options.places; y <= options.places; ++y) {
          mount.xyz << middle + turn * (options.spacing * Eigen::Vector2d(x, y)), low + raised;
          result.push_back(mount);
        }
      }
    }
  }
  return result;
}

}  // namespace

double grasp_cost(const geometry::ObjectModel& object, const GraspPlan& plan,
                  const GraspPlanOptions& options, const Eigen::Vector3d& gravity,
                  const Eigen::Vector3d& p_mount_object) {
  const double weight = object.object().mass * kGravity;
  const auto balance = distribute_forces(plan.contacts, options.friction, options.press,
                                         Load{p_mount_object, weight * gravity});
  return balance.wrench_residual + options.missing_finger * plan.missing;
}

double mean_cost(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object,
                 const ClosingTrajectory& path, const GraspPlanOptions& options,
                 const GraspPlan& plan) {
  double sum = plan.cost;
  for (int side = 0; side < 4; ++side) {
    Eigen::Isometry3d moved = T_world_object;
    moved.pretranslate(options.pose_error *
                       Eigen::Vector3d(std::cos(side * pi / 2), std::sin(side * pi / 2), 0));
    sum += std::min(kNoGrasp, Candidate(object, moved, plan.mount).evaluate(path, options).cost);
  }
  return sum / 5;
}

std::optional<GraspPlan> close_virtually(const geometry::ObjectModel& object,
                                         const Eigen::Isometry3d& T_world_object,
                                         const ClosingTrajectory& path,
                                         const hand::MountPosition& mount,
                                         const GraspPlanOptions& options) {
  const Candidate candidate(object, T_world_object, mount);
  if (!candidate.free(path, options)) return std::nullopt;
  return candidate.evaluate(path, options);
}

std::vector<GraspPlan> find_grasps(const geometry::ObjectModel& object,
                                   const Eigen::Isometry3d& T_world_object,
                                   const ClosingTrajectory& path, const hand::Attitude& attitude,
                                   const GraspPlanOptions& options,
                                   const std::vector<double>& avoid) {
  std::vector<GraspPlan> plans;
  for (const auto& mount : places(path, T_world_object.translation(), attitude, options, avoid)) {
    auto plan = close_virtually(object, T_world_object, path, mount, options);
    if (plan && std::isfinite(plan->cost)) plans.push_back(*std::move(plan));
  }
  return plans;
}

std::optional<GraspPlan> plan_grasp(const geometry::ObjectModel& object,
                                    const Eigen::Isometry3d& T_world_object,
                                    const ClosingTrajectory& path, const hand::Attitude& attitude,
                                    const GraspPlanOptions& options,
                                    const std::vector<double>& avoid) {
  return plan_grasp(object, std::vector<PossiblePose>{{T_world_object}}, path, attitude, options,
                    avoid);
}

std::optional<GraspPlan> plan_grasp(const geometry::ObjectModel& object,
                                    const std::vector<PossiblePose>& poses,
                                    const ClosingTrajectory& path, const hand::Attitude& attitude,
                                    const GraspPlanOptions& options,
                                    const std::vector<double>& avoid) {
  for (const auto& [T_world_object, weight] : poses) {
    if (!(weight > 0)) throw std::invalid_argument(fmt::format("a pose has the weight {}", weight));
  }
  if (poses.empty()) throw std::invalid_argument("a grasp is planned for no pose");
  const Eigen::Isometry3d& T_world_object = poses.front().T_world_object;
  auto plans = find_grasps(object, T_world_object, path, attitude, options, avoid);
  if (plans.empty()) return std::nullopt;
  std::stable_sort(plans.begin(), plans.end(),
                   [](const GraspPlan& a, const GraspPlan& b) { return a.cost < b.cost; });
  plans.resize(std::min(plans.size(), poses.size() > 1 ? kMoreFinalists : kFinalists));
  for (auto& plan : plans) {
    plan.cost = mean_cost(object, T_world_object, path, options, plan);
    double sum = poses.front().weight * plan.cost;
    double weight = poses.front().weight;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const auto other =
          close_virtually(object, poses[i].T_world_object, path, plan.mount, options);
      sum += poses[i].weight * (other ? std::min(kNoGrasp, other->cost) : kNoGrasp);
      weight += poses[i].weight;
    }
    plan.expected_cost = poses.size() > 1 ? sum / weight : plan.cost;
  }
  return *std::min_element(plans.begin(), plans.end(), [](const GraspPlan& a, const GraspPlan& b) {
    return a.expected_cost < b.expected_cost;
  });
}

}  // namespace palpate::grasping
