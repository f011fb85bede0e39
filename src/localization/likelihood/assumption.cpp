// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/assumption.hpp"

#include <array>

namespace palpate::localization {
namespace {

/// Shares of the doubt. Noise of points alone stands for hands whose links are off.
constexpr std::array<Assumption, 5> kNoises{
    {{0.5, 0.5, 0, 0.25}, {0.7, 0.7, 0, 0.25}, {1.4, 1.4, 0, 0.2}, {2, 2, 0, 0.2}, {2, 1, 0, 0.1}}};
constexpr double kNoisierShare = 0.5;  // of the doubt about the noise

/// The steps move a contact 10 cm from the centre by a millimetre, about the noise.
constexpr std::array<Assumption, 6> kSizes{{{1, 1, -0.01, 0.2},
                                            {1, 1, 0.01, 0.2},
                                            {1, 1, -0.02, 0.17},
                                            {1, 1, 0.02, 0.17},
                                            {1, 1, -0.03, 0.13},
                                            {1, 1, 0.03, 0.13}}};
static_assert(1 + kNoises.size() + kSizes.size() <= kMaxAssumptions);

template <class Alternatives>
void add(const Alternatives& alternatives, double share, std::vector<Assumption>& all) {
  if (share <= 0) return;
  for (Assumption alternative : alternatives) {
    alternative.share *= share;
    all.push_back(alternative);
  }
}

}  // namespace

std::vector<Assumption> assumptions(const Evidence& evidence) {
  if (!evidence.offsets.empty()) {
    const double doubt = kNoisierShare * evidence.noise_scale_prior;
    std::vector<Assumption> all{{1, 1, 0, 1 - doubt}};
    add(std::array{Assumption{2, 2, 0, 1}}, doubt, all);
    return all;
  }
  const double as_large = 1 - evidence.size_prior;
  std::vector<Assumption> all{{1, 1, 0, as_large * (1 - evidence.noise_scale_prior)}};
  add(kNoises, as_large * evidence.noise_scale_prior, all);
  add(kSizes, evidence.size_prior, all);
  return all;
}

}  // namespace palpate::localization
