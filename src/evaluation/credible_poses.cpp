// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/credible_poses.hpp"

#include <algorithm>

namespace palpate::evaluation {
namespace {

constexpr int kPosesOfAxis = 9;      // of a mode with a free axis
constexpr double kNotDrawn = 0.003;  // probability below which a pose is left out

/// The pose of a mode or, with a free axis, some along it, of equal shares.
void add_poses_of_mode(const localization::Mode& mode, std::vector<CrediblePose>& poses) {
  const int count = mode.free_axis ? kPosesOfAxis : 1;
  for (int i = 0; i < count; ++i) {
    CrediblePose pose{mode.T_frame_object, mode.weight / count};
    if (mode.free_axis) {
      const double angle = mode.free_axis->extent * (2.0 * i / (count - 1) - 1);
      const Eigen::Translation3d to_line(mode.free_axis->point);
      pose.T_frame_object = to_line * Eigen::AngleAxisd(angle, mode.free_axis->direction) *
                            to_line.inverse() * pose.T_frame_object;
    }
    poses.push_back(pose);
  }
}

}  // namespace

std::vector<CrediblePose> credible_poses(const localization::Posterior& posterior,
                                         std::size_t most) {
  std::vector<CrediblePose> poses;
  for (const auto& mode : posterior.modes) add_poses_of_mode(mode, poses);
  for (const auto& T : posterior.further) {
    poses.push_back({T, posterior.unlisted() / static_cast<double>(posterior.further.size())});
  }
  std::erase_if(poses, [](const CrediblePose& pose) { return pose.probability < kNotDrawn; });
  std::stable_sort(poses.begin(), poses.end(), [](const CrediblePose& a, const CrediblePose& b) {
    return a.probability > b.probability;
  });
  poses.resize(std::min(poses.size(), most));
  return poses;
}

}  // namespace palpate::evaluation
