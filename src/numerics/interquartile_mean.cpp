// SPDX-License-Identifier: Apache-2.0
#include "palpate/numerics/interquartile_mean.hpp"

#include <algorithm>

#include "palpate/core/error.hpp"

namespace palpate::numerics {

double interquartile_mean(std::vector<double> values) {
  if (values.empty()) throw BadInput("an interquartile mean of no values");
  std::sort(values.begin(), values.end());
  const auto quarter = static_cast<std::ptrdiff_t>(values.size() / 4);
  return mean({values.begin() + quarter, values.end() - quarter});
}

Interval bootstrap_interquartile_mean(const Strata& strata, int resamples, RandomStream random) {
  if (strata.empty()) throw BadInput("an interquartile mean of no strata");
  for (const auto& stratum : strata) {
    if (stratum.empty()) throw BadInput("a stratum without values");
  }
  std::vector<double> means;
  for (int i = 0; i < resamples; ++i) {
    std::vector<double> drawn;
    for (const auto& stratum : strata) {
      for (std::size_t k = 0; k < stratum.size(); ++k) {
        drawn.push_back(stratum[random.index(stratum.size())]);
      }
    }
    means.push_back(interquartile_mean(std::move(drawn)));
  }
  return {quantile(means, 0.025), quantile(means, 0.975)};
}

}  // namespace palpate::numerics
