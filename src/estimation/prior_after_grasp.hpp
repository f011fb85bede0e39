// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"

namespace palpate::estimation {

/// An object in the closed hand, up to an instant.
struct GraspHistory {
  const geometry::ObjectModel& model;
  const hand::Description& hand;
  const EventLog& log;
  std::size_t closed, at;  ///< readings
  const EstimationOptions& options;
  std::uint64_t seed;
};

/// Where the object is in the hand's mount at the instant, by how it rested: after a grasp that
/// mostly moved it a little, and by what the fingertips measure of that motion.
/// @param resting  in the world, with modes
localization::PosePrior prior_after_grasp(const GraspHistory& held,
                                          localization::Posterior resting);

/// The same, by where it was in the closed hand before that lifted it.
/// @param before_lift  at the reading `closed`, in the hand's mount, with modes
localization::PosePrior prior_after_lift(const GraspHistory& held,
                                         const localization::Posterior& before_lift);

/// One of two priors holds, each as likely.
localization::PosePrior either_of(const localization::PosePrior& one,
                                  const localization::PosePrior& other);

}  // namespace palpate::estimation
