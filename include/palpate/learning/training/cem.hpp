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
    v("population", population, 4, 100000, "candidates a generation");
    v("elite", elite, 2, 100000, "best of them, which the next generation is drawn around");
    v("step", step, 0.01, 1.0, "of the mean towards the elite's");
    v("keep_spread", keep_spread, 0.0, 1.0, "share of the old spread in the new one");
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

/// One generation of the cross-entropy method (Rubinstein 1999; de Boer et al. 2005): draws
/// candidates, normal about the mean, and moves mean and spread towards the best ones. What is
/// drawn depends only on seed and generation, so a search that is resumed goes on the same.
/// @throws BadInput if sizes differ, elite > population, or all scores are NaN
CemGeneration cem_generation(CemState& state, const CemScores& scores, const CemOptions& options,
                             std::uint64_t seed);

}  // namespace palpate::learning
