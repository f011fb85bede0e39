// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/possible_poses.hpp"

#include <algorithm>

#include "palpate/localization/consensus.hpp"

namespace palpate::skills {
namespace {

constexpr double kNearlyCertain = 0.9;      // probability of a pose that alone is planned for
constexpr std::size_t kPossiblePoses = 12;  // that are planned for else
constexpr double kSamePose = 1e-9;

}  // namespace

std::vector<grasping::PossiblePose> possible_poses(const localization::Posterior& resting) {
  const Eigen::Isometry3d& best = resting.modes.front().T_frame_object;
  if (localization::best_probability(resting) > kNearlyCertain) return {{best}};
  auto credible = localization::poses_of(resting);
  std::erase_if(credible, [](const auto& pose) { return !(pose.weight > 0); });
  if (credible.empty()) return {{best}};
  const auto is_best = [&](const auto& pose) { return pose.T.isApprox(best, kSamePose); };
  const auto heavier = [](const auto& a, const auto& b) { return a.weight > b.weight; };
  std::stable_sort(credible.begin(), credible.end(), heavier);
  std::stable_partition(credible.begin(), credible.end(), is_best);
  credible.resize(std::min(credible.size(), kPossiblePoses));
  std::vector<grasping::PossiblePose> poses;
  for (const auto& [T_world_object, weight] : credible) poses.push_back({T_world_object, weight});
  return poses;
}

}  // namespace palpate::skills
