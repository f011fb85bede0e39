// SPDX-License-Identifier: Apache-2.0
#include "localization/search/tempering.hpp"

#include <algorithm>
#include <cmath>

#include "localization/search/importance_weights.hpp"

namespace palpate::localization {
namespace {

constexpr float kScreenMargin = 60;  // energy above the best proposal at which one is dropped
constexpr double kFirstShare = 0.8;  // effective sample size after the screening, of the particles
constexpr double kStepShare = 0.5;   // and after each step of the bridge
constexpr double kMinLadderStep = 0.005;
constexpr double kLadderScaleStep = 0.75;
constexpr double kLastScale = 1.1;  // below this the scale is 1
constexpr double kWidestMove = 12;  // in units of the contacts' noise
constexpr int kLadderBisections = 25;
constexpr double kDifferenceShare = 0.5;  // of the moves that go by the difference of two particles
constexpr double kDifference = 0.75;      // of it at most: 2.38 / sqrt(2 * 6) is best for a normal

/// The particles' log weights when the bridge's exponent grows by `step`.
std::vector<double> bridge_weights(const std::vector<Particle>& particles, double step) {
  std::vector<double> result;
  result.reserve(particles.size());
  for (const Particle& p : particles) {
    result.push_back(step * (static_cast<double>(p.proposal) - static_cast<double>(p.energy)));
  }
  return result;
}

/// The largest step of the bridge, at most `longest`, that leaves `size` effective particles.
double bridge_step(const std::vector<Particle>& particles, double longest, double size) {
  const auto left_after = [&](double step) {
    return effective_sample_size(relative_weights(bridge_weights(particles, step)));
  };
  if (left_after(longest) >= size) return longest;
  double low = 0, high = longest;
  for (int i = 0; i < kLadderBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (left_after(middle) > size ? low : high) = middle;
  }
  return low;
}

/// Systematic resampling to `count` equally weighted particles.
std::vector<Particle> resampled(const std::vector<Particle>& particles,
                                const std::vector<double>& log_weights, int count,
                                RandomStream& random) {
  const std::vector<double> weights = relative_weights(log_weights);
  double total = 0;
  for (const double w : weights) total += w;
  std::vector<Particle> result;
  result.reserve(static_cast<std::size_t>(count));
  const double start = random.uniform();
  std::size_t j = 0;
  double reached = weights[0];
  for (int i = 0; i < count; ++i) {
    const double mark = (start + i) / count * total;
    while (mark > reached && j + 1 < particles.size()) reached += weights[++j];
    result.push_back(particles[j]);
  }
  return result;
}

std::vector<Particle> screened_proposals(const Target& target, const Energy& energy, int count,
                                         RandomStream& random) {
  std::vector<Particle> result;
  float best = kNoBound;
  for (int i = 0; i < count; ++i) {
    Particle particle{target.proposal.draw(random), 0, 0};
    const float bound = best + kScreenMargin;
    particle.energy = energy(particle.pose, bound);
    if (!(particle.energy < bound)) continue;
    best = std::min(best, particle.energy);
    particle.proposal = target.proposal.energy(particle.pose);
    result.push_back(particle);
  }
  return result;
}

/// Rounding makes long products of rotations drift away from rotations.
void straighten(std::vector<Particle>& particles) {
  for (Particle& p : particles) {
    p.pose.R = Eigen::Quaternionf(p.pose.R).normalized().toRotationMatrix();
  }
}

/// The pose moved by part of the difference of two others: long where the particles are spread
/// widely, short where they agree (ter Braak 2006). Exchanging the two goes back.
SearchPose moved_by_difference(const SearchPose& from, const std::vector<SearchPose>& population,
                               RandomStream& random) {
  const SearchPose& a = population[random.index(population.size())];
  const SearchPose& b = population[random.index(population.size())];
  const Eigen::AngleAxisf turn(Eigen::Matrix3f(a.R * b.R.transpose()));
  const auto share = static_cast<float>(kDifference * std::pow(10.0, -random.uniform()));
  return {Eigen::AngleAxisf(share * turn.angle(), turn.axis()).toRotationMatrix() * from.R,
          from.t + share * (a.t - b.t)};
}

/// Metropolis steps on beta energy + (1 - beta) proposal.
void move_particles(std::vector<Particle>& particles, const Target& target, const Energy& energy,
                    double exponent, double scale, int steps, RandomStream& random) {
  const auto beta = static_cast<float>(exponent);
  const double width = std::min(kWidestMove, scale / std::sqrt(std::max(exponent, 0.05)));
  std::vector<SearchPose> population;  // as they are before they move
  for (const Particle& particle : particles) population.push_back(particle.pose);
  for (Particle& particle : particles) {
    for (int step = 0; step < steps; ++step) {
      const SearchPose to = random.uniform() < kDifferenceShare
                                ? moved_by_difference(particle.pose, population, random)
                                : target.moves.draw(particle.pose, width, random);
      const float proposal = beta < 1 ? target.proposal.energy(to) : 0;
      const auto allowance = static_cast<float>(-std::log(1 - random.uniform()));
      const float now = beta * particle.energy + (1 - beta) * particle.proposal;
      const float bound = (now + allowance - (1 - beta) * proposal) / beta;
      if (bound < 0) continue;  // no energy is negative
      const float e = energy(to, bound);
      if (e < bound) particle = {to, e, proposal};
    }
  }
  straighten(particles);
}

std::vector<Particle> bridged(const Target& target, const LocalizerOptions& options,
                              RandomStream& random) {
  const Energy energy = target.energy_at(options.first_scale);
  auto particles = screened_proposals(target, energy, options.proposals, random);
  double exponent = 0;
  double size = kFirstShare * options.particles;
  while (exponent < 1 && !particles.empty()) {
    const double step = bridge_step(particles, 1 - exponent, size);
    const double taken = std::min(1 - exponent, std::max(step, kMinLadderStep));
    particles = resampled(particles, bridge_weights(particles, taken), options.particles, random);
    exponent = taken < 1 - exponent ? exponent + taken : 1;
    move_particles(particles, target, energy, exponent, options.first_scale, options.moves, random);
    size = kStepShare * options.particles;
  }
  return particles;
}

void cool(std::vector<Particle>& particles, const Energy& energy, RandomStream& random) {
  std::vector<double> log_weights;
  for (Particle& p : particles) {
    const float before = p.energy;
    p.energy = energy(p.pose);
    log_weights.push_back(static_cast<double>(before) - static_cast<double>(p.energy));
  }
  particles = resampled(particles, log_weights, static_cast<int>(particles.size()), random);
}

}  // namespace

std::vector<Particle> sample_posterior(const Target& target, const LocalizerOptions& options,
                                       RandomStream random) {
  std::vector<Particle> particles = bridged(target, options, random);
  double scale = options.first_scale;
  while (scale > 1 && !particles.empty()) {
    scale *= kLadderScaleStep;
    if (scale < kLastScale) scale = 1;
    const Energy energy = target.energy_at(scale);
    cool(particles, energy, random);
    move_particles(particles, target, energy, 1, scale,
                   scale > 1 ? options.moves : 2 * options.moves, random);
  }
  return particles;
}

}  // namespace palpate::localization
