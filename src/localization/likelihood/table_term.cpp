// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/table_term.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

float half_square(double deviation, double sigma) {
  return static_cast<float>(0.5 * std::pow(deviation / sigma, 2));
}

/// Square of an angle over that of its sine, by a series in x = 1 - cosine.
float square_over_sine(float cosine) {
  constexpr float kOpposite = 1e-3F;
  const float x = 1 - cosine;
  return 2 * (1 + x / 6 + 2 * x * x / 45 + x * x * x / 70) / std::max(2 - x, kOpposite);
}

}  // namespace

bool TableTerm::Lean::is_far(const Eigen::Vector3f& table_up, float square_over_sine) const {
  const float far = table_up.dot(far_scaled);
  if ((far > 0) != far_along) return false;
  const float near = table_up.dot(scaled);
  return 0.5F * (near * near - far * far) * square_over_sine > minus_log_far;
}

double TableTerm::Lean::mass() const {
  const double ratio = far_sigma / sigma;
  if (ratio <= 1) return 1;
  // Both are equal where (1 - 1 / ratio^2) (a / sigma)^2 / 2 = ln ratio.
  const double equal = std::sqrt(std::log(ratio) / (1 - 1 / (ratio * ratio)));
  return 1 + (std::erf(equal) - std::erf(equal / ratio)) / 2;
}

double TableTerm::Lean::draw(RandomStream& random) const {
  if (far_sigma == sigma) return sigma * random.normal();
  const double side = far_along ? -1 : 1;
  while (true) {  // from the sum of both densities, of which the larger one is kept
    const bool far = random.uniform() < 1.0 / 3;
    const double turn =
        far ? side * std::abs(far_sigma * random.normal()) : sigma * random.normal();
    if (turn * side <= 0) return turn;
    const double a = std::exp(-half_square(turn, sigma)) / sigma;
    const double b = std::exp(-half_square(turn, far_sigma)) / far_sigma;
    if (random.uniform() * (a + b) < std::max(a, b)) return turn;
  }
}

float TableTerm::StablePose::lean_energy(const Eigen::Vector3f& table_up) const {
  const float over_sine = square_over_sine(table_up.dot(up));
  const bool far_0 = leans[0].is_far(table_up, over_sine);
  const bool far_1 = leans[1].is_far(table_up, over_sine);
  const float a = table_up.dot(far_0 ? leans[0].far_scaled : leans[0].scaled);
  const float b = table_up.dot(far_1 ? leans[1].far_scaled : leans[1].scaled);
  return 0.5F * (a * a + b * b) * over_sine + (far_0 ? leans[0].minus_log_far : 0) +
         (far_1 ? leans[1].minus_log_far : 0);
}

TableTerm::TableTerm(const geometry::ObjectModel& model, const TableSupport& table)
    : table_(table),
      height_sigma_(std::hypot(table.height_sigma, table.surface_sigma)),
      origin_(table.T_frame_table.translation().cast<float>()),
      axes_(table.T_frame_table.linear().cast<float>()) {
  const auto& stable_poses = model.object().stable_poses;
  const bool given = !table.stable_pose_weights.empty();
  double total = 0;
  for (std::size_t s = 0; s < stable_poses.size(); ++s) {
    total += given ? table.stable_pose_weights[s] : stable_poses[s].probability;
  }
  for (std::size_t s = 0; s < stable_poses.size(); ++s) {
    const double weight =
        (given ? table.stable_pose_weights[s] : stable_poses[s].probability) / total;
    if (weight <= 0) continue;
    stable_poses_.push_back(stable_pose(model, s, weight));
  }
}

/// Where it leans more, its density is lower.
TableTerm::StablePose TableTerm::stable_pose(const geometry::ObjectModel& model, std::size_t number,
                                             double weight) const {
  const geometry::StablePose& known = model.object().stable_poses[number];
  const geometry::RestingSlack& slack = model.resting_slack()[number];
  const Eigen::Matrix3d& R = known.R_table_object;
  StablePose pose{R, R.row(2).transpose().cast<float>(), known.height, weight, 0, {}};
  double density = weight;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto sigma_to = [&](int side) {
      return std::hypot(
          table_.tilt_sigma,
          slack.lean_to(side, static_cast<int>(i), table_.surface_sigma, table_.centroid_sigma));
    };
    const double against = sigma_to(0), along = sigma_to(1);
    Lean& lean = pose.leans[i];
    lean.direction = slack.directions()[i];
    lean.sigma = std::min(against, along);
    lean.far_sigma = std::max(against, along);
    lean.far_along = along > against;
    lean.minus_log_far = static_cast<float>(std::log(lean.far_sigma / lean.sigma));
    lean.scaled = (lean.direction / lean.sigma).cast<float>();
    lean.far_scaled = (lean.direction / lean.far_sigma).cast<float>();
    density *= table_.tilt_sigma / (lean.sigma * lean.mass());
  }
  pose.minus_log_weight = static_cast<float>(-std::log(density));
  return pose;
}

TableTerm::Nearest TableTerm::nearest_stable_pose(const Eigen::Vector3f& up, float height) const {
  Nearest nearest{nullptr, std::numeric_limits<float>::infinity()};
  for (const StablePose& stable_pose : stable_poses_) {
    const float energy =
        stable_pose.lean_energy(up) +
        half_square(static_cast<double>(height) - stable_pose.height, height_sigma_) +
        stable_pose.minus_log_weight;
    if (energy < nearest.energy) nearest = {&stable_pose, energy};
  }
  return nearest;
}

float TableTerm::energy(const SearchPose& pose, float) const {
  const Eigen::Vector3f at = axes_.transpose() * (pose.t - origin_);
  float resting = nearest_stable_pose(pose.R.transpose() * axes_.col(2), at.z()).energy;
  for (int axis = 0; axis < 2; ++axis) {
    const double beyond = static_cast<double>(std::abs(at[axis])) - table_.half_width;
    if (beyond > 0) resting += half_square(beyond, table_.edge_sigma);
  }
  return resting;
}

void TableTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  const Eigen::Matrix3d axes = axes_.cast<double>();
  const Eigen::Vector3d at = axes.transpose() * (pose.t - origin_).cast<double>();
  const Eigen::Vector3f up = pose.R.transpose() * axes_.col(2);
  const StablePose* const stable_pose =
      nearest_stable_pose(up, static_cast<float>(at.z())).stable_pose;
  if (!stable_pose) return;
  const Eigen::Vector3d rests_on = (pose.R * stable_pose->up).cast<double>();
  const float over_sine = square_over_sine(up.dot(stable_pose->up));
  const double scale = std::sqrt(over_sine);
  for (const Lean& lean : stable_pose->leans) {
    const double sigma = lean.is_far(up, over_sine) ? lean.far_sigma : lean.sigma;
    const Eigen::Vector3d direction = pose.R.cast<double>() * lean.direction * (scale / sigma);
    Eigen::Matrix<double, 1, 6> tilt = Eigen::Matrix<double, 1, 6>::Zero();
    tilt.leftCols<3>() = direction.transpose() * skew(rests_on);
    equations.add(tilt, Eigen::Matrix<double, 1, 1>(direction.dot(axes.col(2) - rests_on)), 1);
  }
  const auto add_shift = [&](int axis, double shift, double sigma) {
    Eigen::Matrix<double, 1, 6> J = Eigen::Matrix<double, 1, 6>::Zero();
    J.tail<3>() = axes.col(axis).transpose() / sigma;
    equations.add(J, Eigen::Matrix<double, 1, 1>(shift / sigma), 1);
  };
  add_shift(2, at.z() - stable_pose->height, height_sigma_);
  for (int axis = 0; axis < 2; ++axis) {
    const double beyond = std::abs(at[axis]) - table_.half_width;
    if (beyond > 0) add_shift(axis, std::copysign(beyond, at[axis]), table_.edge_sigma);
  }
}

double TableTerm::log_peak() const {
  const double root = std::sqrt(2 * std::numbers::pi);
  const double side = 2 * table_.half_width + root * table_.edge_sigma;
  const double tilts = std::pow(root * table_.tilt_sigma, 2);
  const double yaws = 2 * std::numbers::pi;
  return -std::log(tilts * yaws * root * height_sigma_ * side * side);
}

double TableTerm::draw_offset(RandomStream& random) const {
  const double flat = 2 * table_.half_width;
  const double edges = table_.edge_sigma * std::sqrt(2 * std::numbers::pi);
  const double at = random.uniform(0, flat + edges) - edges;
  if (at >= 0) return at - table_.half_width;
  const double beyond = table_.edge_sigma * random.normal();
  return beyond + std::copysign(table_.half_width, beyond);
}

SearchPose TableTerm::draw(RandomStream& random) const {
  double left = random.uniform();
  std::size_t s = 0;
  while (s + 1 < stable_poses_.size() && left >= stable_poses_[s].weight)
    left -= stable_poses_[s++].weight;
  const StablePose& stable_pose = stable_poses_[s];
  Eigen::Vector3d lean = Eigen::Vector3d::Zero();  // of the object, in its frame
  for (const Lean& one : stable_pose.leans) {
    lean += one.draw(random) * stable_pose.up.cast<double>().cross(one.direction);
  }
  const Eigen::Vector3d yaw(0, 0, random.uniform(-std::numbers::pi, std::numbers::pi));
  const Eigen::Matrix3d R_table_object = exp_so3(yaw) * stable_pose.R_table_object * exp_so3(lean);
  const double x = draw_offset(random), y = draw_offset(random);
  const double z = stable_pose.height + height_sigma_ * random.normal();
  return {axes_ * R_table_object.cast<float>(),
          axes_ * Eigen::Vector3d(x, y, z).cast<float>() + origin_};
}

}  // namespace palpate::localization
