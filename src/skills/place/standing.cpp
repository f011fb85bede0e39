// SPDX-License-Identifier: Apache-2.0
#include "skills/place/standing.hpp"

#include <array>
#include <cmath>

#include "estimation/in_hand_motion.hpp"
#include "palpate/skills/place/place_target.hpp"

namespace palpate::skills {
namespace {

constexpr double kOtherSide = 0.1;  // probability that it leans by more than its mesh would
constexpr double kOtherLean = 0.2;  // rad, then

/// Lean to both directions in which an object leans, normal: mean and standard deviation, rad.
struct Lean {
  double weight = 1;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d sigma = Eigen::Vector2d::Constant(kOtherLean);
};
using LeanBelief = std::array<Lean, 2>;

/// Before it was seen to stand.
LeanBelief expected_lean(const geometry::ObjectModel& object, std::size_t stable_pose,
                         const estimation::EstimationOptions& options) {
  const geometry::RestingSlack& slack = object.resting_slack()[stable_pose];
  LeanBelief belief;
  belief[0].weight = 1 - kOtherSide;
  belief[1].weight = kOtherSide;
  for (int i = 0; i < 2; ++i) {
    belief[0].sigma[i] = slack.lean(i, options.surface_sigma, options.centroid_sigma);
  }
  return belief;
}

/// By Bayes' rule, each normal distribution with its own evidence.
LeanBelief with_measured(LeanBelief belief, const Eigen::Vector2d& lean, double error) {
  double sum = 0;
  for (Lean& part : belief) {
    for (int i = 0; i < 2; ++i) {
      const double variance = part.sigma[i] * part.sigma[i], total = variance + error * error;
      part.weight *= std::exp(-0.5 * lean[i] * lean[i] / total) / std::sqrt(total);
      part.mean[i] = variance / total * lean[i];
      part.sigma[i] = error * std::sqrt(variance / total);
    }
    sum += part.weight;
  }
  for (Lean& part : belief) part.weight /= sum;
  return belief;
}

double share_within(const Lean& lean, double most) {
  constexpr int kSteps = 20;       // to either side
  constexpr double kWidest = 4.0;  // standard deviations
  double inside = 0, all = 0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      const Eigen::Vector2d z = kWidest / kSteps * Eigen::Vector2d(i, j);
      const double density = std::exp(-0.5 * z.squaredNorm());
      all += density;
      if ((lean.mean + lean.sigma.cwiseProduct(z)).norm() < most) inside += density;
    }
  }
  return inside / all;
}

double share_within(const LeanBelief& belief, double most) {
  double share = 0;
  for (const Lean& part : belief) share += part.weight * share_within(part, most);
  return share;
}

/// Onto the table, turned the shortest way until that direction of the object is up.
Eigen::Isometry3d set_on_table(const geometry::KnownObject& object, Eigen::Isometry3d T,
                               const Eigen::Vector3d& up) {
  T.linear() =
      Eigen::Quaterniond::FromTwoVectors(T.linear() * up, Eigen::Vector3d::UnitZ()) * T.linear();
  T.translation().z() = 0;
  T.translation().z() = -geometry::lowest_point(T, object.mesh);
  return T;
}

}  // namespace

Standing standing_of(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object,
                     double tilt_error, const estimation::EstimationOptions& options, double most) {
  const auto [stable_pose, tilt] = nearest_stable_pose(object.object(), T_world_object.linear());
  const auto& directions = object.resting_slack()[stable_pose].directions();
  const Eigen::Vector3d up = T_world_object.linear().row(2);
  const double scale = tilt > 1e-9 ? tilt / std::sin(tilt) : 1;
  const LeanBelief belief = with_measured(
      expected_lean(object, stable_pose, options),
      scale * Eigen::Vector2d(directions[0].dot(up), directions[1].dot(up)), tilt_error);
  const Eigen::Vector2d mean =
      belief[0].weight * belief[0].mean + belief[1].weight * belief[1].mean;
  Standing standing;
  standing.lean = mean.norm();
  standing.upright = share_within(belief, most);
  const Eigen::Vector3d to = mean[0] * directions[0] + mean[1] * directions[1];
  const double sine = standing.lean > 1e-9 ? std::sin(standing.lean) / standing.lean : 1;
  const Eigen::Vector3d rests =
      object.object().stable_poses[stable_pose].R_table_object.row(2).transpose();
  const Eigen::Isometry3d T =
      set_on_table(object.object(), T_world_object, std::cos(standing.lean) * rests + sine * to);
  standing.T_flat_object = laid_flat(object.object(), T_world_object).inverse() * T;
  return standing;
}

Standing as_it_stood(const geometry::ObjectModel& object, const Executor& robot,
                     const Eigen::Isometry3d& T_mount_object,
                     const estimation::EstimationOptions& options, double most) {
  constexpr double kTiltError = 0.03, kSwung = 0.2;  // rad; the latter where two fingers hold it
  const estimation::EventLog& log = robot.log();
  const auto closed = log.at(estimation::TouchEvent::closed).value();
  const auto held = log.at(estimation::TouchEvent::held).value_or(closed);
  const auto moved = estimation::in_hand_motion(robot.model(), log, closed, held, options.errors);
  return standing_of(object, log.readings[closed].mount.pose() * moved.T.inverse() * T_mount_object,
                     moved.loose.empty() ? kTiltError : kSwung, options, most);
}

double upright_probability(const geometry::ObjectModel& object, std::size_t stable_pose,
                           const estimation::EstimationOptions& options, double most) {
  return share_within(expected_lean(object, stable_pose, options), most);
}

}  // namespace palpate::skills
