// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/localizer.hpp"

#include <algorithm>
#include <chrono>

#include "check_evidence.hpp"
#include "contact_term.hpp"
#include "free_space_term.hpp"
#include "modes.hpp"
#include "moves.hpp"
#include "prior_term.hpp"
#include "proposal.hpp"
#include "table_term.hpp"
#include "tempering.hpp"

namespace palpate::localization {
namespace {

constexpr double kCertain = 0.95;
constexpr double kUncontestedFloor = 1e-12;  // of a prior that no contact can overrule
constexpr int kWeighingShare = 2;  // the population that weighs the modes is so many times smaller

/// Builds the sum of the terms that the evidence calls for, at any noise scale.
class EnergyMaker {
 public:
  EnergyMaker(const ObjectModel& model, const Evidence& evidence, const LocalizerOptions& options)
      : model_(model), evidence_(evidence), options_(options) {
    if (evidence.prior) prior_ = std::make_shared<const PoseMixture>(*evidence.prior);
    if (evidence.free_space.empty()) return;
    clearance_ = std::make_shared<const Clearance>(model.field(), model.object().mesh);
  }

  Energy operator()(double scale) const {
    Energy energy;  // cheap and telling terms first
    if (prior_) energy.add(std::make_unique<PriorTerm>(prior_, prior_floor()));
    if (evidence_.table) energy.add(std::make_unique<TableTerm>(model_, *evidence_.table));
    if (!evidence_.contacts.empty()) {
      energy.add(std::make_unique<ContactTerm>(model_, evidence_, options_.contact_offset, scale));
    }
    if (clearance_) {
      energy.add(std::make_unique<FreeSpaceTerm>(model_, evidence_, clearance_, scale));
    }
    return energy;
  }

 private:
  /// The floor holds nearly everywhere, so without contacts most of the mass would be on it.
  double prior_floor() const {
    return evidence_.contacts.empty() ? kUncontestedFloor : evidence_.prior->floor;
  }

  const ObjectModel& model_;
  const Evidence& evidence_;
  const LocalizerOptions& options_;
  std::shared_ptr<const PoseMixture> prior_;
  std::shared_ptr<const Clearance> clearance_;
};

std::vector<PosePoint> poses_of(const std::vector<Particle>& particles) {
  std::vector<PosePoint> result;
  for (const Particle& particle : particles) {
    result.emplace_back(Eigen::Quaterniond(particle.pose.R.cast<double>()).normalized(),
                        particle.pose.t.cast<double>());
  }
  return result;
}

/// Whether the best pose leaves more than half of the contacts unexplained.
bool contradicted(const std::vector<Particle>& particles, const ObjectModel& model,
                  const Evidence& evidence, const LocalizerOptions& options) {
  const auto best =
      std::min_element(particles.begin(), particles.end(),
                       [](const Particle& a, const Particle& b) { return a.energy < b.energy; });
  const ContactTerm contacts(model, evidence, options.contact_offset, 1.0);
  return 2 * contacts.unexplained(best->pose) > static_cast<int>(contacts.size());
}

PoseStatus status_of(const std::vector<Mode>& modes) {
  if (modes.empty()) return PoseStatus::no_pose;
  const Mode& best = modes.front();
  return best.weight > kCertain && !best.free_axis ? PoseStatus::certain : PoseStatus::ambiguous;
}

Posterior search(const ObjectModel& model, const Evidence& evidence, const RandomStream& random,
                 const LocalizerOptions& options) {
  const auto proposal = make_proposal(model, evidence, options);
  const Moves moves(model, evidence);
  const Target target{*proposal, moves, EnergyMaker(model, evidence, options)};
  LocalizerOptions smaller = options;
  smaller.proposals /= kWeighingShare;
  smaller.particles /= kWeighingShare;
  const auto chosen_on = sample_posterior(target, options, random.fork("choosing"));
  if (chosen_on.empty() || contradicted(chosen_on, model, evidence, options)) return {};
  const auto weighed_on = sample_posterior(target, smaller, random.fork("weighing"));
  if (weighed_on.empty()) return {};
  Posterior posterior;
  posterior.modes = find_modes(poses_of(chosen_on), poses_of(weighed_on),
                               symmetry_quaternions(model.object().symmetries));
  posterior.status = status_of(posterior.modes);
  return posterior;
}

}  // namespace

Posterior localize(const ObjectModel& model, const Evidence& evidence, RandomStream random,
                   const LocalizerOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check_evidence(model, evidence);
  Posterior posterior;
  if (evidence.prior || evidence.table || !evidence.contacts.empty()) {
    posterior = search(model, evidence, random, options);
  }
  posterior.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return posterior;
}

}  // namespace palpate::localization
