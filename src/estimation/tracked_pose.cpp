// SPDX-License-Identifier: Apache-2.0
#include "estimation/tracked_pose.hpp"

#include <algorithm>

#include "palpate/estimation/track.hpp"
#include "palpate/localization/consensus.hpp"

namespace palpate::estimation {
namespace {

constexpr double kTrackedShare = 0.4;  // that the pose is the one tracked, not the one found

}  // namespace

localization::Mode track_best_mode(const GraspHistory& held, std::size_t until,
                                   const localization::Posterior& before_lift) {
  localization::Posterior start;
  start.modes = {before_lift.modes.front()};
  transform(held.log.readings[held.closed].mount.pose(), start);
  const TrackInput input{.object = held.model,
                         .hand = held.hand,
                         .log = held.log,
                         .start = start,
                         .first = held.closed,
                         .last = until,
                         .errors = held.options.errors};
  return track(input, {}, held.seed).posterior.modes.front();
}

void add_tracked_pose(localization::Mode tracked, const std::vector<Eigen::Matrix3d>& symmetries,
                      localization::Posterior& posterior) {
  if (posterior.modes.empty()) return;
  const auto apart =
      localization::mode_error(posterior.modes.front(), tracked.T_frame_object, symmetries);
  const localization::SamePose same;
  if (apart.rotation < same.angle && apart.translation < same.distance) return;
  for (auto& mode : posterior.modes) mode.weight *= 1 - kTrackedShare;
  tracked.weight *= kTrackedShare;
  posterior.modes.push_back(tracked);
  std::stable_sort(posterior.modes.begin(), posterior.modes.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  posterior.status = localization::PoseStatus::ambiguous;
}

}  // namespace palpate::estimation
