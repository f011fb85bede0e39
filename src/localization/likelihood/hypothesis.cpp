// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/hypothesis.hpp"

#include <array>

namespace palpate::localization {
namespace {

/// Shares of the prior of each hypothesis. Noise of points alone stands for hands whose links are
/// off.
constexpr std::array<Hypothesis, 5> kNoises{
    {{0.5, 0.5, 0, 0.25}, {0.7, 0.7, 0, 0.25}, {1.4, 1.4, 0, 0.2}, {2, 2, 0, 0.2}, {2, 1, 0, 0.1}}};
constexpr double kNoisierShare = 0.5;  // of the prior of noise of another scale

/// The steps move a contact 10 cm from the centre by a millimetre, about the noise.
constexpr std::array<Hypothesis, 6> kSizes{{{1, 1, -0.01, 0.2},
                                            {1, 1, 0.01, 0.2},
                                            {1, 1, -0.02, 0.17},
                                            {1, 1, 0.02, 0.17},
                                            {1, 1, -0.03, 0.13},
                                            {1, 1, 0.03, 0.13}}};
static_assert(1 + kNoises.size() + kSizes.size() <= kMaxNoiseHypotheses);

template <class Alternatives>
void add(const Alternatives& alternatives, double share, std::vector<Hypothesis>& all) {
  if (share <= 0) return;
  for (Hypothesis alternative : alternatives) {
    alternative.share *= share;
    all.push_back(alternative);
  }
}

}  // namespace

std::vector<Hypothesis> hypotheses(const Evidence& evidence) {
  if (!evidence.offsets.empty()) {
    const double noisier = kNoisierShare * evidence.noise_scale_prior;
    std::vector<Hypothesis> all{{1, 1, 0, 1 - noisier}};
    add(std::array{Hypothesis{2, 2, 0, 1}}, noisier, all);
    return all;
  }
  const double as_large = 1 - evidence.size_prior;
  std::vector<Hypothesis> all{{1, 1, 0, as_large * (1 - evidence.noise_scale_prior)}};
  add(kNoises, as_large * evidence.noise_scale_prior, all);
  add(kSizes, evidence.size_prior, all);
  return all;
}

}  // namespace palpate::localization
