// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace palpate::learning {

struct CemOptions {
  int population = 48;       ///< candidates a generation; the first is the mean
  int elite = 8;             ///< best of them, which the next generation is drawn around
  double step = 0.8;         ///< of the mean towards the elite's
  double keep_spread = 0.3;  ///< share of the old spread in the new one

  template <class Visitor>
  void visit(Visitor&& v) {
    v("population", population, 4, 100000, "number of candidates per generation");
    v("elite", elite, 2, 100000,
      "number of best candidates around which the next generation is drawn");
    v("step", step, 0.01, 1.0, "step of the mean towards that of the elite, as a share");
    v("keep_spread", keep_spread, 0.0, 1.0, "share of the previous spread in the next one");
  }
};

/// Where a search is: what a checkpoint holds.
struct CemState {
  int generation = 0;
  Eigen::VectorXd mean, spread;
};

/// Score of a candidate, to be maximised; candidates of one generation are compared.
using CemScores = std::function<std::vector<double>(const std::vector<Eigen::VectorXd>&)>;

struct CemGeneration {
  double best = 0, elite = 0, mean = 0;  ///< scores: of the best, mean of the elite, of the mean
};

/// Candidates of the next generation, normal about the mean, which is the first of them. They
/// depend only on the state and the seed, so that a search goes on the same wherever they are
/// scored.
/// @throws BadInput if sizes differ, or elite > population
std::vector<Eigen::VectorXd> cem_candidates(const CemState& state, const CemOptions& options,
                                            std::uint64_t seed);

/// Moves mean and spread towards the best of the candidates (the cross-entropy method, Rubinstein
/// 1999; de Boer et al. 2005).
/// @throws BadInput if sizes differ, or no score is finite
CemGeneration cem_update(CemState& state, const std::vector<Eigen::VectorXd>& candidates,
                         std::vector<double> scores, const CemOptions& options);

/// One generation: candidates, their scores, and the update.
/// @throws BadInput as these do
CemGeneration cem_generation(CemState& state, const CemScores& scores, const CemOptions& options,
                             std::uint64_t seed);

}  // namespace palpate::learning
