// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/localizer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include "localization/likelihood/check_evidence.hpp"
#include "localization/likelihood/energy_maker.hpp"
#include "localization/likelihood/goodness_of_fit.hpp"
#include "localization/likelihood/surface_error.hpp"
#include "localization/likelihood/thinning.hpp"
#include "localization/search/descent.hpp"
#include "localization/search/modes.hpp"
#include "localization/search/moves.hpp"
#include "localization/search/proposal.hpp"
#include "localization/search/residual_set.hpp"
#include "localization/search/tempering.hpp"

namespace palpate::localization {
namespace {

constexpr int kWeighingShare = 2;  // the population that weighs the modes is so many times smaller
constexpr int kScreenedShare = 6;  // refining needs so many times fewer proposals than sampling
constexpr int kProposalsPerParticle = 4;
constexpr std::size_t kConstraints = 3;  // of a contact, distance and normal; and of a table
constexpr std::size_t kEnough = 12;      // twice a pose's freedoms
constexpr int kMaxOpen = 1;              // directions of a basin that a chain of basins can cover
constexpr double kMaxUnseen = 0.05;      // of fresh poses, outside the balls of those there are
constexpr int kMore = 3;                 // times the samples are drawn besides where it is more

std::vector<PosePoint> poses_of(const std::vector<Particle>& particles) {
  std::vector<PosePoint> result;
  for (const Particle& particle : particles) {
    result.emplace_back(Eigen::Quaterniond(particle.pose.R.cast<double>()).normalized(),
                        particle.pose.t.cast<double>());
  }
  return result;
}

void append(std::vector<PosePoint>& poses, const std::vector<PosePoint>& more) {
  poses.insert(poses.end(), more.begin(), more.end());
}

const SearchPose& best_of(const std::vector<Particle>& particles) {
  return std::min_element(particles.begin(), particles.end(),
                          [](const Particle& a, const Particle& b) { return a.energy < b.energy; })
      ->pose;
}

/// The search for populations of samples.
class Sampler {
 public:
  Sampler(const geometry::ObjectModel& model, const Evidence& evidence,
          const LocalizerOptions& options)
      : options_(options),
        energy_at_(model, evidence, options),
        proposal_(make_proposal(model, evidence, options)),
        moves_(model, evidence),
        symmetries_(model.object().symmetries),
        half_turns_(half_turns(model.object())),
        many_contacts_(many_contacts(evidence, options)) {
    options_.first_scale = energy_at_.first_scale();
  }

  const PoseFamily::Symmetries& symmetries() const { return symmetries_; }

  /// Those that descents from the best proposals find, where the evidence closes them; else none.
  std::vector<Basin> basins(RandomStream random) const {
    if (!many_contacts_) return {};
    auto found = find_basins(
        *proposal_, energy_at_, symmetries_,
        {options_.proposals / kScreenedShare, options_.starts, options_.first_scale, half_turns_},
        random);
    return closed(found) ? std::move(found) : std::vector<Basin>{};
  }

  /// Many more about basins, which matters more than that each is moved about much.
  std::vector<PosePoint> more(const std::vector<Basin>& basins, const RandomStream& random,
                              int share) const {
    LocalizerOptions options = options_;
    options.particles = kMore * options.particles / share;
    options.moves = std::max(1, options.moves / kMore);
    return poses_of(sample_about(basins, options, random));
  }

  /// About basins: a mixture about them covers the posterior, and none is lost that is narrow at
  /// enlarged noise. Without any, from the proposals, broadly.
  std::vector<Particle> operator()(const std::vector<Basin>& basins, RandomStream random,
                                   int share) const {
    LocalizerOptions options = options_;
    options.particles /= share;
    if (!basins.empty()) return sample_about(basins, options, random.fork("basins"));
    options.proposals /= share;
    return sample_posterior({*proposal_, moves_, energy_at_}, options, random.fork("broad"));
  }

 private:
  /// Contacts at one point or on a plane leave more open than basins cover.
  static bool closed(const std::vector<Basin>& basins) {
    return !basins.empty() && open_directions(basins.front().best) <= kMaxOpen;
  }

  /// Where a prior may be wrong, contacts must be heard all over.
  static bool many_contacts(const Evidence& evidence, const LocalizerOptions& options) {
    std::size_t constraints = evidence.table ? kConstraints : 0;
    std::set<int> groups;  // of candidates, each of which counts once
    for (const tactile::Contact& contact : evidence.contacts) {
      if (contact.group >= 0 && !groups.insert(contact.group).second) continue;
      constraints += contact.has_normal() ? kConstraints : 1;
    }
    return options.starts > 0 && !evidence.prior && constraints >= kEnough;
  }

  std::vector<Particle> sample_about(const std::vector<Basin>& basins, LocalizerOptions options,
                                     const RandomStream& random) const {
    const auto about = mixture_proposal(mixture_about(basins));
    options.proposals = kProposalsPerParticle * options.particles;
    options.first_scale = 1;
    return sample_posterior({*about, moves_, energy_at_}, options, random);
  }

  LocalizerOptions options_;
  EnergyMaker energy_at_;
  std::unique_ptr<Proposal> proposal_;
  Moves moves_;
  PoseFamily::Symmetries symmetries_;
  std::vector<Eigen::Matrix3d> half_turns_;
  bool many_contacts_;
};

Posterior search(const geometry::ObjectModel& model, const Evidence& evidence,
                 const RandomStream& random, const LocalizerOptions& options) {
  const Sampler sample(model, evidence, options);
  const auto basins = sample.basins(random.fork("descents"));
  const auto chosen_on = sample(basins, random.fork("choosing"), 1);
  if (chosen_on.empty() ||
      fit_is_rejected(model, evidence, best_of(chosen_on), options.contact_offset)) {
    return {};
  }
  const auto weighed_on = sample(basins, random.fork("weighing"), kWeighingShare);
  if (weighed_on.empty()) return {};
  auto choosing = poses_of(chosen_on), weighing = poses_of(weighed_on);
  Posterior posterior;
  posterior.modes =
      find_modes(choosing, weighing, sample.symmetries(), static_cast<std::size_t>(options.modes));
  if (!basins.empty() && unseen_share(weighing, choosing, sample.symmetries()) > kMaxUnseen) {
    append(choosing, sample.more(basins, random.fork("more"), 1));
    append(weighing, sample.more(basins, random.fork("more weighing"), kWeighingShare));
  }
  auto rest = residual_set(posterior.modes, choosing, weighing, sample.symmetries());
  posterior.residual_set = std::move(rest.poses);
  posterior.credible_mass = std::max(rest.credible_mass, 1 - posterior.residual_mass());
  posterior.status = status_of(posterior.modes);
  // No contact tells what is elsewhere from what the prior's components hold.
  const bool prior_alone = evidence.prior && evidence.contacts.empty();
  return prior_alone ? weighted(std::move(posterior), total_weight(*evidence.prior)) : posterior;
}

}  // namespace

Posterior localize(const geometry::ObjectModel& model, const Evidence& evidence,
                   RandomStream random, const LocalizerOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check_evidence(model, evidence);
  Posterior posterior;
  if (evidence.prior || evidence.table || !evidence.contacts.empty()) {
    posterior = search(model, thinned(with_surface_error(evidence)), random, options);
  }
  posterior.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return posterior;
}

}  // namespace palpate::localization
