// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "localization/likelihood/search_pose.hpp"
#include "palpate/core/random.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// A distribution of poses that the search starts from.
class Proposal {
 public:
  virtual ~Proposal() = default;
  virtual SearchPose draw(RandomStream& random) const = 0;

  /// Minus the logarithm of its density, per rad^3 m^3.
  virtual float energy(const SearchPose& pose) const = 0;
};

/// From the prior if there is one (and beside it, in a share of the draws, from what would be used
/// without it), else from the table if there is one, else from single contacts (of which there must
/// be one).
std::unique_ptr<Proposal> make_proposal(const geometry::ObjectModel& model,
                                        const Evidence& evidence, const LocalizerOptions& options);

/// A mixture of normal distributions.
std::unique_ptr<Proposal> mixture_proposal(const PosePrior& mixture);

}  // namespace palpate::localization
