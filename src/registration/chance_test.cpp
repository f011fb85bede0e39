// SPDX-License-Identifier: Apache-2.0
#include "chance_test.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/registration/chance.hpp"

namespace palpate::registration {
std::vector<int> stratified_sample(int size, int count, RandomStream random) {
  std::vector<int> sample(static_cast<std::size_t>(std::min(size, count)));
  const double width = static_cast<double>(size) / static_cast<double>(sample.size());
  for (std::size_t i = 0; i < sample.size(); ++i) {
    const double position =
        (static_cast<double>(i) + (size > count ? random.uniform() : 0)) * width;
    sample[i] = std::min(size - 1, static_cast<int>(position));
  }
  return sample;
}

ConsistencyGraph graph_of(const Correspondences& correspondences, const ConsensusOptions& options) {
  return ConsistencyGraph(correspondences, {.noise_bound = options.noise_bound,
                                            .normal_noise_deg = options.normal_noise_deg});
}

double ChanceTest::quick_bound(const Eigen::Isometry3d& T, double triples) const {
  return expected(scorer_.score(T), triples, rate({T}, 4));
}

double ChanceTest::operator()(const Eigen::Isometry3d& T, double triples) {
  const Score score = scorer_.score(T);
  const bool few = scorer_.size() <= kFew, pooled = poses_.size() >= kEnoughPoses;
  if (few && wrong_triples_ < 0) wrong_triples_ = wrong_triples();
  return expected(score, few ? std::min(triples, wrong_triples_) : triples,
                  pooled ? pooled_rate(score.count - 3) : rate({T}, 64));
}

double ChanceTest::triples_from(const ConsistencyGraph& graph) const {
  return (graph.triangles() + 1) * triples_of(scorer_.size()) /
         triples_of(std::max(3, graph.size()));
}

double ChanceTest::expected(const Score& score, double triples, double rate) const {
  const ChanceModel model{.triples = triples, .rate = rate, .dimensions = scorer_.dimensions()};
  return expected_by_chance(model, score.count - score.gain, score.count);
}

/// Mean number of correspondences within the bound at the poses, were they paired anew: every
/// source with the targets some places on.
double ChanceTest::rate(const std::vector<Eigen::Isometry3d>& poses, std::size_t shifts) const {
  const auto others = static_cast<std::size_t>(scorer_.size() - 1);
  RandomStream random = random_.fork("shift");
  double hits = 1, samples = 1;
  for (const Eigen::Isometry3d& T : poses) {
    for (std::size_t k = 0; k < std::min(shifts, others); ++k) {
      hits += scorer_.count_shifted(T, 1 + static_cast<int>(random.index(others)));
      samples += scorer_.size();
    }
  }
  return scorer_.size() * std::min(1.0, hits / samples);
}

/// The rate whose power is the mean of the pooled poses' rates to that power: some places, as large
/// flat ones, gather far more than the mean. Of counts that are Poisson, the mean of
/// h (h - 1) .. (h - power + 1) is the power of the rate without bias.
double ChanceTest::pooled_rate(int power) {
  constexpr int kShifts = 16;
  for (std::size_t i = hits_.size(); i < poses_.size(); ++i) {
    hits_.push_back(rate({poses_[i]}, kShifts) * kShifts - 1);
  }
  double sum = 0, moment = 0;
  for (const double hits : hits_) {
    double product = 1;
    for (int i = 0; i < power; ++i) product *= std::max(0.0, hits - i) / kShifts;
    sum += hits;
    moment += product;
  }
  const auto count = static_cast<double>(hits_.size());
  const double mean = (sum + 1) / (count * kShifts);
  return power < 1 ? mean : std::max(mean, std::pow(moment / count, 1.0 / power));
}

/// Consistent triples among wrong correspondences: targets paired anew at random.
double ChanceTest::wrong_triples() const {
  constexpr int kPairings = 4;
  RandomStream random = random_.fork("pairing");
  double sum = 0;
  for (int k = 0; k < kPairings; ++k) {
    Correspondences wrong = correspondences_;
    for (std::size_t i = 0; i + 1 < wrong.size(); ++i) {
      const std::size_t j = i + 1 + random.index(wrong.size() - i - 1);  // none stays (Sattolo)
      std::swap(wrong.target[i], wrong.target[j]);
      if (wrong.has_normals()) std::swap(wrong.target_normals[i], wrong.target_normals[j]);
    }
    sum += triples_from(graph_of(wrong, options_));
  }
  return sum / kPairings;
}

}  // namespace palpate::registration
