// SPDX-License-Identifier: Apache-2.0
#include <palpate/registration/pose.hpp>

int main() {
  palpate::registration::Correspondences pairs;
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, 0, 0),
                                   Eigen::Vector3d(0, 0.1, 0), Eigen::Vector3d(0, 0, 0.1)}) {
    pairs.source.push_back(p);
    pairs.target.push_back(p + Eigen::Vector3d(1, 2, 3));
  }
  const auto pose = palpate::registration::align_points(pairs, {1, 1, 1, 1});
  return (pose.translation() - Eigen::Vector3d(1, 2, 3)).norm() < 1e-9 ? 0 : 1;
}
