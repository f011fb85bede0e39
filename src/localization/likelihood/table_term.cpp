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

}  // namespace

TableTerm::TableTerm(const geometry::ObjectModel& model, const TableSupport& table)
    : table_(table),
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
    const Eigen::Matrix3d& R = stable_poses[s].R_table_object;
    stable_poses_.push_back({R, R.row(2).transpose().cast<float>(), stable_poses[s].height, weight,
                             static_cast<float>(-std::log(weight))});
  }
}

TableTerm::Nearest TableTerm::nearest_stable_pose(const Eigen::Vector3f& up, float height) const {
  const auto tilt_precision = static_cast<float>(1 / std::pow(table_.tilt_sigma, 2));
  Nearest nearest{nullptr, std::numeric_limits<float>::infinity()};
  for (const StablePose& stable_pose : stable_poses_) {
    const float energy =
        (1 - up.dot(stable_pose.up)) * tilt_precision +
        half_square(static_cast<double>(height) - stable_pose.height, table_.height_sigma) +
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
  Eigen::Matrix<double, 3, 6> tilt = Eigen::Matrix<double, 3, 6>::Zero();
  tilt.leftCols<3>() = skew(rests_on) / table_.tilt_sigma;
  equations.add(tilt, ((axes.col(2) - rests_on) / table_.tilt_sigma).eval(), 1);
  const auto add_shift = [&](int axis, double shift, double sigma) {
    Eigen::Matrix<double, 1, 6> J = Eigen::Matrix<double, 1, 6>::Zero();
    J.tail<3>() = axes.col(axis).transpose() / sigma;
    equations.add(J, Eigen::Matrix<double, 1, 1>(shift / sigma), 1);
  };
  add_shift(2, at.z() - stable_pose->height, table_.height_sigma);
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
  return -std::log(tilts * yaws * root * table_.height_sigma * side * side);
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
  const Eigen::Vector3d tilt(table_.tilt_sigma * random.normal(),
                             table_.tilt_sigma * random.normal(), 0);
  const Eigen::Vector3d yaw(0, 0, random.uniform(-std::numbers::pi, std::numbers::pi));
  const Eigen::Matrix3d R_table_object = exp_so3(tilt) * exp_so3(yaw) * stable_pose.R_table_object;
  const double x = draw_offset(random), y = draw_offset(random);
  const double z = stable_pose.height + table_.height_sigma * random.normal();
  return {axes_ * R_table_object.cast<float>(),
          axes_ * Eigen::Vector3d(x, y, z).cast<float>() + origin_};
}

}  // namespace palpate::localization
