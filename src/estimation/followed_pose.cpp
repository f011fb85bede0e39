// SPDX-License-Identifier: Apache-2.0
#include "estimation/followed_pose.hpp"

#include <algorithm>

#include "palpate/estimation/track.hpp"

namespace palpate::estimation {
namespace {

constexpr double kFollowedShare = 0.4;  // that the pose is the one followed, not the one found
constexpr double kSameRotation = 0.0873, kSameTranslation = 0.010;  // rad, m

}  // namespace

localization::Mode follow(const HeldObject& held, std::size_t until,
                          const localization::Posterior& before_lift) {
  localization::Posterior start;
  start.modes = {before_lift.modes.front()};
  transform(held.log.readings[held.closed].base.pose(), start);
  return track(held.model, held.hand, held.log, held.options.errors, start, held.closed, until, {},
               held.seed)
      .posterior.modes.front();
}

void add_followed_pose(localization::Mode followed, const std::vector<Eigen::Matrix3d>& symmetries,
                       localization::Posterior& posterior) {
  if (posterior.modes.empty()) return;
  const auto apart =
      localization::mode_error(posterior.modes.front(), followed.T_frame_object, symmetries);
  if (apart.rotation < kSameRotation && apart.translation < kSameTranslation) return;
  for (auto& mode : posterior.modes) mode.weight *= 1 - kFollowedShare;
  followed.weight *= kFollowedShare;
  posterior.modes.push_back(followed);
  std::stable_sort(posterior.modes.begin(), posterior.modes.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  posterior.status = localization::PoseStatus::ambiguous;
}

}  // namespace palpate::estimation
