// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "localization/likelihood/evidence_term.hpp"
#include "localization/search/moves.hpp"
#include "localization/search/proposal.hpp"

namespace palpate::localization {

struct Particle {
  SearchPose pose;
  float energy = 0;    ///< at the present noise scale
  float proposal = 0;  ///< energy under the proposal
};

/// What tempered sampling needs to know of a posterior.
struct Target {
  const Proposal& proposal;
  const Moves& moves;
  std::function<Energy(double)> energy_at;  ///< the energy at a noise scale
};

/// Equally weighted samples of exp(-energy_at(1)), by sequential Monte Carlo (Del Moral, Doucet and
/// Jasra 2006): screened proposals, a geometric bridge from the proposal to the posterior at
/// options.first_scale whose steps halve the effective sample size, then the noise scale down to 1.
/// Empty when no proposal has a finite energy.
std::vector<Particle> sample_posterior(const Target& target, const LocalizerOptions& options,
                                       RandomStream random);

}  // namespace palpate::localization
