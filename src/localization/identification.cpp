// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/identification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "localization/likelihood/contact_term.hpp"
#include "localization/likelihood/energy_maker.hpp"
#include "localization/likelihood/goodness_of_fit.hpp"
#include "localization/likelihood/plane_term.hpp"
#include "localization/likelihood/prior_term.hpp"
#include "localization/likelihood/surface_error.hpp"
#include "localization/likelihood/table_term.hpp"
#include "localization/likelihood/thinning.hpp"
#include "palpate/core/error.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::localization {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();
constexpr int kSamples = 3000;       // of the mixture
constexpr double kWidened = 2;       // times the modes' covariances: the tails must be covered
constexpr double kObjectSize = 0.1;  // m, over which the surface of another object is off

Matrix6d independent_errors(double angle, double step) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(angle * angle), Eigen::Vector3d::Constant(step * step);
  return variance.asDiagonal();
}

/// A mixture that covers the posterior amply.
PosePrior covering(const Posterior& posterior) {
  PosePrior mixture = prior_from(posterior, Matrix6d::Zero());
  for (auto& component : mixture.components) component.covariance *= kWidened;
  return mixture;
}

/// Density of the mixture, the same for all symmetric copies of a pose.
double symmetric_density(const PoseMixture& mixture, const SearchPose& pose,
                         const std::vector<Eigen::Matrix3f>& symmetries) {
  double sum = 0;
  for (const Eigen::Matrix3f& turn : symmetries) {
    sum += mixture.relative_density({pose.R * turn, pose.t});
  }
  return sum / static_cast<double>(symmetries.size());
}

/// What the energy of the evidence lacks of -ln(prior times likelihood), up to a constant that all
/// objects share.
double log_scale(const geometry::ObjectModel& model, const Evidence& evidence,
                 double contact_offset) {
  double sum = 0;
  if (!evidence.contacts.empty()) {
    sum += ContactTerm(model, evidence, contact_offset, 1).log_peak();
  }
  if (!evidence.planes.empty()) sum += PlaneTerm(model, evidence, 1).log_peak();
  if (evidence.table) sum += TableTerm(model, *evidence.table).log_peak();
  if (evidence.prior) {
    sum += PriorTerm(std::make_shared<const PoseMixture>(*evidence.prior), evidence.prior->floor)
               .log_peak();
  }
  return sum;
}

/// A prior is about one of the symmetric copies of a pose; without one they are all alike.
std::vector<Eigen::Matrix3f> alike(const geometry::ObjectModel& model, const Evidence& evidence) {
  if (evidence.prior) return {Eigen::Matrix3f::Identity()};
  std::vector<Eigen::Matrix3f> turns;
  for (const auto& turn : model.object().symmetries) turns.push_back(turn.cast<float>());
  return turns;
}

double log_mean(const std::vector<double>& logs, int count) {
  const double most = *std::max_element(logs.begin(), logs.end());
  if (most == kNever) return kNever;
  double sum = 0;
  for (const double value : logs) sum += std::exp(value - most);
  return most + std::log(sum / count);
}

/// What was known of a pose, where each may be off besides. The floor stays the density that
/// it was.
PosePrior widened_prior(PosePrior prior, const Matrix6d& covariance) {
  const double before = PoseMixture(prior).log_peak();
  for (auto& component : prior.components) component.covariance += covariance;
  const double scale = std::exp(before - PoseMixture(prior).log_peak());
  prior.floor = std::min(0.5, scale * prior.floor);  // as spread_elsewhere()
  return prior;
}

/// The evidence, of an object whose surface is off the candidate's. Unlike a mesh's error, which
/// changes within millimetres, that of another object is much the same over a whole side: it raises
/// or lowers what is touched, and turns it by no more than the error over the object's size, which
/// is little beside the noise of normals and the lean of what rests.
Evidence of_another_object(const Evidence& evidence, double sigma) {
  Evidence other = with_surface_error(evidence);  // the mesh's own
  const double turn = sigma / kObjectSize;
  for (tactile::Contact& contact : other.contacts) {
    contact.point_sigma = std::hypot(contact.point_sigma, sigma);
    contact.normal_sigma = std::hypot(contact.normal_sigma, turn);
  }
  for (PlaneContact& plane : other.planes) plane.sigma = std::hypot(plane.sigma, sigma);
  if (other.table) {
    other.table->height_sigma = std::hypot(other.table->height_sigma, sigma);
    other.table->tilt_sigma = std::hypot(other.table->tilt_sigma, turn);
  }
  other.penetration_sigma = std::hypot(other.penetration_sigma, sigma);
  if (other.prior)
    other.prior = widened_prior(*std::move(other.prior), independent_errors(turn, sigma));
  return other;
}

LocalizerOptions coarser(LocalizerOptions options) {
  options.proposals /= 2;
  options.particles /= 2;
  return options;
}

}  // namespace

double log_marginal_likelihood(const geometry::ObjectModel& model, const Evidence& evidence,
                               const Posterior& posterior, RandomStream random,
                               const LocalizerOptions& options) {
  if (posterior.modes.empty()) return kNever;
  const Evidence used = thinned(with_surface_error(evidence));
  const PoseMixture mixture(covering(posterior));
  const Energy energy = EnergyMaker(model, used, options)(1);
  const auto symmetries = alike(model, used);
  std::vector<double> logs;
  for (int i = 0; i < kSamples; ++i) {
    const SearchPose pose = mixture.draw(random);
    const double density = symmetric_density(mixture, pose, symmetries);
    if (density <= 0) continue;  // rounded
    logs.push_back(-static_cast<double>(energy(pose)) - std::log(density) - mixture.log_peak());
  }
  if (logs.empty()) return kNever;
  return log_mean(logs, kSamples) + log_scale(model, used, options.contact_offset);
}

ObjectHypothesis hypothesis_of(const geometry::ObjectModel& model, const Evidence& evidence,
                               const RandomStream& random, const LocalizerOptions& options,
                               const IdentificationOptions& identification) {
  ObjectHypothesis hypothesis;
  hypothesis.posterior = localize(model, evidence, random, options);
  hypothesis.log_evidence = log_marginal_likelihood(model, evidence, hypothesis.posterior,
                                                    random.fork("evidence"), options);
  // The poses that fit less exactly lie farther apart than the candidate's, and need fewer samples.
  const Evidence other = of_another_object(evidence, identification.other_sigma);
  const RandomStream its = random.fork("other");
  hypothesis.log_evidence_other = log_marginal_likelihood(
      model, other, localize(model, other, its, coarser(options)), its.fork("evidence"), options);
  return hypothesis;
}

ObjectProbabilities object_probabilities(const std::vector<ObjectHypothesis>& hypotheses,
                                         const IdentificationOptions& options) {
  if (hypotheses.empty()) throw BadInput("0 hypotheses of which object it is");
  double most = kNever;
  for (const auto& h : hypotheses) {
    most = std::max({most, h.log_evidence, h.log_evidence_other});
  }
  ObjectProbabilities result;
  result.candidates.assign(hypotheses.size(), 0);
  if (most == kNever) return result;
  const auto count = static_cast<double>(hypotheses.size());
  double total = 0;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    result.candidates[i] =
        (1 - options.other) / count * std::exp(hypotheses[i].log_evidence - most);
    result.other += options.other / count * std::exp(hypotheses[i].log_evidence_other - most);
    total += result.candidates[i];
  }
  total += result.other;
  for (double& probability : result.candidates) probability /= total;
  result.other /= total;
  result.best = static_cast<std::size_t>(
      std::max_element(result.candidates.begin(), result.candidates.end()) -
      result.candidates.begin());
  result.probability = result.candidates[result.best];
  return result;
}

}  // namespace palpate::localization
