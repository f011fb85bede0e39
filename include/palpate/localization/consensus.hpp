// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

/// A pose that an estimate holds for credible, and its share.
struct WeightedPose {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double weight = 0;
};

/// Largest distance between poses that count as the same one: the default PoseTolerance, to the
/// digits that a configuration file has.
struct SamePose {
  double angle = 0.0872665;  ///< rad (5 deg)
  double distance = 0.010;   ///< m

  template <class Visitor>
  void visit(Visitor&& v) {
    v("angle", angle, 1e-3, 3.2, "rad, rotation within which two poses count as the same");
    v("distance", distance, 1e-4, 0.5, "m, distance within which two poses count as the same");
  }
};

/// Where most of the weight is: the mean of the poses around the one that has most of it nearby.
struct PoseConsensus {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double share = 0;  ///< of the whole weight that lies within SamePose, 0..1
};

/// Modes as poses; one with a free axis as several along it.
std::vector<WeightedPose> poses_of(const localization::Posterior& posterior);

/// What there is to be learnt about which of some poses is the true one, nats.
/// @param same  poses that differ by less from a heavier one count as that
double entropy(std::vector<WeightedPose> poses, const SamePose& same);

/// @param symmetries  of the object, identity first: poses that differ by one are the same
/// @return share 0 where there are no poses
PoseConsensus consensus(const std::vector<WeightedPose>& poses,
                        const std::vector<Eigen::Matrix3d>& symmetries, const SamePose& same);

}  // namespace palpate::localization
