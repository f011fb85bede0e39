// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/registration/cloud_registration.hpp"

namespace palpate::registration {

/// Of the search among matches of features.
RegistrationOptions feature_search(const CloudOptions& options,
                                   const CloudRegistration& registration);

/// A cloud by its features, and in the detail that poses are refined with.
struct PreparedCloud {
  const FeatureCloud& described;
  const geometry::PointCloud& dense;
};

/// Poses that features, too, may speak for.
struct Alternatives {
  bool clear = false;  ///< the answer is far clearer than chance: only what lies at hand is tried
  std::vector<Eigen::Isometry3d> poses;
  std::optional<Eigen::Isometry3d> T_mirrored;  ///< of the source's mirror image
};

/// Pose from the matches of features. Unless these are clear, and nearly all of the source lies on
/// the target, and rather so than mirrored, also what else they may mean: which of that fits is
/// left to the dense clouds.
Alternatives match_prepared(const PreparedCloud& from, const PreparedCloud& to,
                            const CloudOptions& options, CloudRegistration& registration);

/// Puts a pose that fits the dense clouds better in the place of the one that matches of features
/// gave, if those speak for it, too; the former is the runner-up. A pose that is worse by far than
/// one that they do not speak for is withdrawn.
/// @return the pose that fits better, if there is one
std::optional<Eigen::Isometry3d> prefer_better_fit(const PreparedCloud& from,
                                                   const PreparedCloud& to,
                                                   const Alternatives& other,
                                                   const CloudOptions& options,
                                                   CloudRegistration& registration);

}  // namespace palpate::registration
