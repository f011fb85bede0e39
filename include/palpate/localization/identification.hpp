// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

struct IdentificationOptions {
  double other = 0.05;         ///< prior probability of an object that is none of the candidates
  double other_sigma = 0.004;  ///< m by which the surface of such an object is off the candidate's

  template <class Visitor>
  void visit(Visitor&& v) {
    v("other", other, 0.0, 0.99, "prior probability that the object is none of the candidates");
    v.expert(
        "other_sigma", other_sigma, 0.001, 0.05,
        "m, surface error assumed for an object that is similar to a candidate but none of them");
  }
};

/// What evidence says if the object is one of some candidates.
struct ObjectHypothesis {
  Posterior posterior;  ///< of the pose, given that it is this object
  /// ln p(evidence | object), and of another object that is like it, both up to a constant that all
  /// objects share; minus infinity where no pose explains the evidence.
  double log_evidence = 0, log_evidence_other = 0;
};

/// ln of the integral of prior times likelihood over all poses, by importance sampling from a
/// mixture about the posterior's modes and residual set (Robert & Casella 2004, ch. 3). Comparable
/// between objects for the same evidence with Evidence::contact_area.
/// @param posterior  of localize(), of this evidence
/// @return minus infinity for a posterior without modes
double log_marginal_likelihood(const geometry::ObjectModel& model, const Evidence& evidence,
                               const Posterior& posterior, RandomStream random,
                               const LocalizerOptions& options = {});

/// Searches as localize() and weighs the object against others.
/// @param evidence  with Evidence::contact_area, the same for all objects
ObjectHypothesis hypothesis_of(const geometry::ObjectModel& model, const Evidence& evidence,
                               const RandomStream& random, const LocalizerOptions& options,
                               const IdentificationOptions& identification);

/// Which of the candidates it is; equally probable before.
struct ObjectProbabilities {
  std::vector<double> candidates;  ///< one each; with `other` they sum to 1
  double other = 0;                ///< that it is none of them
  std::size_t best = 0;            ///< index of the most probable
  /// That it is the best one, and its size relative to its mesh; where candidates are sizes of one
  /// shape, that it is that shape in any size, and its mean size (choose_shape()).
  double probability = 0, size = 1;
};

/// @return all 0 where no pose of any candidate explains the evidence
/// @throws BadInput for no hypotheses
ObjectProbabilities object_probabilities(const std::vector<ObjectHypothesis>& hypotheses,
                                         const IdentificationOptions& options);

}  // namespace palpate::localization
