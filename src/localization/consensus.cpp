// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/consensus.hpp"

#include <algorithm>
#include <cmath>

#include "localization/search/symmetry_group.hpp"

namespace palpate::localization {
namespace {

constexpr int kAlongAxis = 2;  // poses to either side of a mode with a free axis

/// The equivalent of a pose whose orientation is nearest to that of another.
Eigen::Isometry3d nearest_equivalent(const Eigen::Isometry3d& T, const Eigen::Isometry3d& other,
                                     const SymmetryGroup& symmetries) {
  Eigen::Isometry3d nearest = T;
  const Eigen::Quaterniond between(Eigen::Matrix3d(T.linear().transpose() * other.linear()));
  nearest.linear() = T.linear() * symmetries.nearest(between).toRotationMatrix();
  return nearest;
}

}  // namespace

std::vector<WeightedPose> poses_of(const localization::Posterior& posterior) {
  std::vector<WeightedPose> poses;
  for (const auto& mode : posterior.modes) {
    if (!mode.free_axis) {
      poses.push_back({mode.T_frame_object, mode.weight});
      continue;
    }
    const auto& axis = *mode.free_axis;
    for (int k = -kAlongAxis; k <= kAlongAxis; ++k) {
      const double angle = axis.extent * k / (kAlongAxis + 0.5);
      poses.push_back({Eigen::Translation3d(axis.point) * Eigen::AngleAxisd(angle, axis.direction) *
                           Eigen::Translation3d(-axis.point) * mode.T_frame_object,
                       mode.weight / (2 * kAlongAxis + 1)});
    }
  }
  return poses;
}

double entropy(std::vector<WeightedPose> poses, const SamePose& same) {
  std::stable_sort(poses.begin(), poses.end(), [](const WeightedPose& a, const WeightedPose& b) {
    return a.weight > b.weight;
  });
  std::vector<WeightedPose> distinct;
  double total = 0;
  for (const WeightedPose& pose : poses) {
    total += pose.weight;
    const auto known = std::find_if(distinct.begin(), distinct.end(), [&](const auto& other) {
      return rotation_distance(pose.T.linear(), other.T.linear()) < same.angle &&
             (pose.T.translation() - other.T.translation()).norm() < same.distance;
    });
    if (known == distinct.end()) {
      distinct.push_back(pose);
    } else {
      known->weight += pose.weight;
    }
  }
  double sum = 0;
  for (const WeightedPose& pose : distinct) {
    const double share = pose.weight / total;
    if (share > 0) sum -= share * std::log(share);
  }
  return sum;
}

PoseConsensus consensus(const std::vector<WeightedPose>& poses,
                        const std::vector<Eigen::Matrix3d>& symmetries, const SamePose& same) {
  PoseConsensus best;
  const SymmetryGroup group(symmetries);
  double total = 0;
  for (const auto& pose : poses) total += pose.weight;
  for (const auto& center : poses) {
    double near = 0;
    Vector6d sum = Vector6d::Zero();
    for (const auto& pose : poses) {
      const Eigen::Isometry3d T = nearest_equivalent(pose.T, center.T, group);
      Vector6d apart;
      apart << log_so3(T.linear() * center.T.linear().transpose()),
          T.translation() - center.T.translation();
      if (apart.head<3>().norm() > same.angle || apart.tail<3>().norm() > same.distance) continue;
      near += pose.weight;
      sum += pose.weight * apart;
    }
    if (near <= best.share * total) continue;
    best.share = near / total;
    best.T.linear() = exp_so3(sum.head<3>() / near) * center.T.linear();
    best.T.translation() = center.T.translation() + sum.tail<3>() / near;
  }
  return best;
}

}  // namespace palpate::localization
