// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "estimation/prior_after_grasp.hpp"

namespace palpate::estimation {

/// The most probable pose at GraspHistory::closed, tracked tick by tick to a later reading as the
/// contacts wander over the object; in the hand's mount.
/// @param before_lift  at the reading `closed`, in the hand's mount, with modes
localization::Mode track_best_mode(const GraspHistory& held, std::size_t until,
                                   const localization::Posterior& before_lift);

/// Where the object was tracked to another pose (by 5 deg or 10 mm) than the most probable one, it
/// may be in either: both rest on the same contacts, so that one of them is wrong, however sure.
/// The tracked pose then gets a share of 0.4, and the posterior is ambiguous.
/// @param symmetries  of the object
void add_tracked_pose(localization::Mode tracked, const std::vector<Eigen::Matrix3d>& symmetries,
                      localization::Posterior& posterior);

}  // namespace palpate::estimation
