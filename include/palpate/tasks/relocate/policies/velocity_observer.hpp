// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/tasks/relocate/training/structured_search.hpp"

namespace palpate::relocate {

struct ObserverOptions {
  int hidden = 64;             ///< units of each of two hidden layers
  int rounds = 4;              ///< of collecting frames under the policy and fitting
  int episodes = 48;           ///< a round
  double perturbation = 0.02;  ///< of the parameters, as a share of the search's first spread
  int samples = 400000;        ///< to fit on in a round: its epochs times the frames so far

  template <class Visitor>
  void visit(Visitor&& v) {
    v("hidden", hidden, 1, 1024, "number of units in each of the two hidden layers");
    v("rounds", rounds, 1, 1000,
      "number of rounds of collecting frames with the policy and fitting");
    v("episodes", episodes, 1, 100000, "number of episodes per round");
    v("perturbation", perturbation, 0.0, 1.0,
      "perturbation of the parameters, as a share of the first spread");
    v("samples", samples, 1, 1000000000, "number of samples fitted per round");
  }
};

struct ObserverFit {
  StructuredPolicy::Observer observer;
  double r2 = 0;  ///< of the velocities of the last round's frames, before they were learnt from
};

/// Learns to estimate the base's velocity from one frame, on the frames that the policy meets: in
/// the first round it reads the velocity, from then on it relies on the observer of the round
/// before (Ross et al. 2011). Each episode runs a slightly perturbed policy, so that the observer
/// also holds near by. A policy that has an observer relies on it, and it is where the fit starts.
/// @param worlds  an episode takes place in one of them, one after the other
/// @throws BadInput if no frame was met
ObserverFit fit_observer(const std::vector<RelocateModel>& worlds, const StructuredPolicy& policy,
                         const EpisodeOptions& episode, const ObserverOptions& options,
                         std::uint64_t seed, int threads);

}  // namespace palpate::relocate
