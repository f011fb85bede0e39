// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/contact_term.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr float kShortestGradient = 0.3F;  // interpolated across a medial sheet: no direction
constexpr float kCurvatureStep = 0.001F;   // m, over which the gradient's change is measured
constexpr double kMinTrust = 0.02;         // of a contact off the surface: it still draws the pose
constexpr float kHopeless = 30;            // misfit whose likelihood rounds to that of a false one
constexpr float kMinProduct = 1e-18F;      // times the least factor still is a float
constexpr float kOffsetReach = 3;          // standard deviations that an offset is within
constexpr int kFitSteps = 2;               // of reweighting contacts for the offset

}  // namespace

ContactTerm::ContactTerm(const geometry::ObjectModel& model, const Evidence& evidence,
                         double offset, double scale)
    : field_(model.field()) {
  for (const tactile::Contact& contact : evidence.contacts) {
    const Eigen::Vector3d n = contact.n.normalized();  // zero stays zero
    contacts_.push_back({(contact.p + offset * n).cast<float>(), n.cast<float>()});
    if (contact.has_normal()) contacts_.back().offset = static_cast<float>(offset);
  }
  for (const CommonModeBias& shared : evidence.offsets) {
    Group group{static_cast<float>(1 / (shared.sigma * shared.sigma)), {}};
    for (const auto& member : shared.members) {
      contacts_[member.contact].R_offset_frame = member.R_frame_offset.transpose().cast<float>();
      contacts_[member.contact].reach = kOffsetReach * static_cast<float>(shared.sigma);
      group.members.push_back(member.contact);
    }
    groups_.push_back(std::move(group));
  }
  const std::vector<Hypothesis> levels = hypotheses(evidence);
  priors_.resize(static_cast<Eigen::Index>(levels.size()));
  growth_.resize(priors_.size());
  for (std::size_t j = 0; j < levels.size(); ++j) {
    priors_[static_cast<Eigen::Index>(j)] = static_cast<float>(levels[j].share);
    growth_[static_cast<Eigen::Index>(j)] = static_cast<float>(levels[j].growth);
    max_growth_ = std::max(max_growth_, std::abs(static_cast<float>(levels[j].growth)));
  }
  for (const tactile::Contact& contact : evidence.contacts) {
    noise_.push_back(make_noise(model, evidence, contact, levels, scale));
  }
  gather_sets(evidence);
}

void ContactTerm::gather_sets(const Evidence& evidence) {
  std::map<int, std::vector<std::size_t>> groups;
  for (std::size_t k = 0; k < evidence.contacts.size(); ++k) {
    if (evidence.contacts[k].group >= 0) groups[evidence.contacts[k].group].push_back(k);
  }
  for (auto& [name, members] : groups) {
    const auto count = static_cast<float>(members.size());
    CandidateSet set;
    Levels all = Levels::Zero(growth_.size());
    for (const std::size_t k : members) {
      Noise& noise = noise_[k];
      noise.odds /= count;
      contacts_[k].set = static_cast<int>(sets_.size());
      all += noise.odds;
      set.stated_cap = std::max(set.stated_cap, std::log1p(noise.odds[0]));
    }
    set.cap = std::log1p(all.maxCoeff());
    set.inverse_peak = std::exp(-set.cap);
    for (const std::size_t k : members) noise_[k].inverse_peak = set.inverse_peak;
    set.members = std::move(members);
    sets_.push_back(std::move(set));
  }
}

std::size_t ContactTerm::size() const {
  std::size_t count = contacts_.size() + sets_.size();
  for (const CandidateSet& set : sets_) count -= set.members.size();
  return count;
}

double ContactTerm::log_peak() const {
  double sum = 0;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (!is_candidate(k)) sum += static_cast<double>(noise_[k].cap);
  }
  for (const CandidateSet& set : sets_) sum += static_cast<double>(set.cap);
  return sum;
}

void ContactTerm::Product::multiply(const Levels& factor) {
  likelihood *= factor;
  const float most = likelihood.maxCoeff();
  if (most > kMinProduct) return;
  likelihood /= most;
  log_scale += std::log(most);
}

ContactTerm::NormalFit ContactTerm::normal_fit(std::size_t k, float q) const {
  const float outlier_share = noise_[k].outlier_share;
  const float near = (1 - outlier_share) * std::exp(-q);
  const float far = outlier_share / kOutlierVariance * std::exp(-q / kOutlierVariance);
  const float density = std::max(near + far, std::numeric_limits<float>::min());
  return {density, outlier_share > 0 ? (near + far / kOutlierVariance) / density : 1};
}

ContactTerm::Residual ContactTerm::residual_at(const Datum& contact, const SearchPose& pose,
                                               const Located& at) const {
  Residual residual;
  if (!at.cell.node) return residual;
  const geometry::DistanceField::Sample sample = field_.at(at.cell);
  residual.near = true;
  residual.squared_curvature = sample.squared_curvature;
  residual.distance = sample.distance - contact.offset;
  const float length = std::max(kShortestGradient, sample.gradient.norm());
  residual.normal = 1 - (pose.R.transpose() * contact.n).dot(sample.gradient) / length;
  residual.scale_derivative = sample.distance - at.y.dot(sample.gradient) / length;
  if (contact.reach > 0)
    residual.slope = contact.R_offset_frame * (pose.R * sample.gradient) / length;
  return residual;
}

std::vector<ContactTerm::Residual> ContactTerm::residuals_at(const SearchPose& pose) const {
  std::vector<Residual> residuals;
  residuals.reserve(contacts_.size());
  for (const Datum& contact : contacts_) residuals.push_back(residual_at(contact, pose));
  return residuals;
}

ContactTerm::Levels ContactTerm::likelihood(std::size_t k, const Residual& residual,
                                            float slack) const {
  const Noise& noise = noise_[k];
  const float min_distance =
      std::max(0.0F, std::abs(residual.distance) -
                         max_growth_ * std::abs(residual.scale_derivative) - slack);
  const float min_q = min_distance * min_distance * noise.min_half_point_precision +
                      residual.normal * noise.min_normal_precision / kOutlierVariance /
                          (1 + noise.max_curvature_widening * residual.squared_curvature);
  if (!residual.near || min_q > kHopeless) {
    return Levels::Constant(growth_.size(), noise.inverse_peak);
  }
  if (growth_.size() == kMaxNoiseHypotheses && slack == 0) {
    return likelihood_at_all(noise, growth_, residual);
  }
  Levels distance = residual.distance + growth_ * residual.scale_derivative;
  if (slack > 0) distance = (distance.abs() - slack).max(0.0F);
  const Levels wider = 1 + noise.curvature_widening * residual.squared_curvature;
  const Levels qn = residual.normal * noise.normal_precision / wider;
  const Levels normal = (1 - noise.outlier_share) * (-qn).exp() +
                        noise.outlier_share / kOutlierVariance * (-qn / kOutlierVariance).exp();
  return (1 +
          noise.odds / wider * normal * (-distance.square() * noise.half_point_precision).exp()) *
         noise.inverse_peak;
}

ContactTerm::Levels ContactTerm::likelihood(const CandidateSet& set, const SearchPose& pose) const {
  Levels sum = Levels::Constant(growth_.size(), set.inverse_peak);
  for (const std::size_t k : set.members) {
    sum += likelihood(k, residual_at(contacts_[k], pose), 0) - set.inverse_peak;
  }
  return sum;
}

float ContactTerm::odds(std::size_t k, const Residual& residual, float distance,
                        Eigen::Index level) const {
  const LevelNoise noise = noise_at(k, level, residual.squared_curvature);
  const float q = distance * distance * noise.half_point_precision;
  if (!residual.near || q >= kHopeless) return 0;
  return noise.odds * std::exp(-q) *
         normal_fit(k, residual.normal * noise.normal_precision).density;
}

float ContactTerm::odds(const CandidateSet& set, const std::vector<Residual>& residuals,
                        Eigen::Index level) const {
  float sum = 0;
  for (const std::size_t k : set.members)
    sum += odds(k, residuals[k], distance_at(residuals[k], level), level);
  return sum;
}

float ContactTerm::contact_energy(std::size_t k, const Residual& residual, float distance,
                                  Eigen::Index level) const {
  return noise_[k].cap - std::log1p(odds(k, residual, distance, level));
}

float ContactTerm::contact_energy(std::size_t k, const SearchPose& pose) const {
  const Residual residual = residual_at(contacts_[k], pose);
  return noise_[k].stated_cap - noise_[k].cap + contact_energy(k, residual, residual.distance, 0);
}

/// Reweighted least squares. The first weights bear with a contact as far off as the offset may be.
ContactTerm::Fit ContactTerm::fit(const Group& group, const std::vector<Residual>& residuals,
                                  Eigen::Index level) const {
  Fit fit;
  const float variance = 1 / group.precision;
  for (int step = 0; step < kFitSteps; ++step) {
    Eigen::Matrix3f H = group.precision * Eigen::Matrix3f::Identity();
    Eigen::Vector3f g = Eigen::Vector3f::Zero();
    for (const std::size_t k : group.members) {
      if (!residuals[k].near) continue;
      const LevelNoise noise = noise_at(k, level, residuals[k].squared_curvature);
      const float precision = 2 * noise.half_point_precision;
      const float distance = distance_at(residuals[k], level) + residuals[k].slope.dot(fit.offset);
      const float patience = step == 0 ? 1 + variance * precision : 1;
      const float q = distance * distance * noise.half_point_precision / patience;
      if (q >= kHopeless) continue;
      const float normal = normal_fit(k, residuals[k].normal * noise.normal_precision).density;
      const float odds = noise.odds * std::exp(-q) * normal;
      const float weight = odds / (1 + odds) * precision;
      H.noalias() += weight * residuals[k].slope * residuals[k].slope.transpose();
      g += weight * distance_at(residuals[k], level) * residuals[k].slope;
    }
    fit.information = H;
    fit.offset = -H.inverse() * g;
  }
  return fit;
}

float ContactTerm::group_energy(const Group& group, const std::vector<Residual>& residuals,
                                Eigen::Index level) const {
  const Fit best = fit(group, residuals, level);
  float sum = 0.5F * group.precision * best.offset.squaredNorm() +
              0.5F * std::log(best.information.determinant() / std::pow(group.precision, 3.0F));
  for (const std::size_t k : group.members) {
    sum += contact_energy(k, residuals[k],
                          distance_at(residuals[k], level) + residuals[k].slope.dot(best.offset),
                          level);
  }
  return sum;
}

ContactTerm::Levels ContactTerm::level_energies(const Product& alone,
                                                const std::vector<Residual>& residuals) const {
  Levels sums = -priors_.log() - alone.likelihood.log() - alone.log_scale;
  for (const Group& group : groups_) {
    for (Eigen::Index j = 0; j < sums.size(); ++j) sums[j] += group_energy(group, residuals, j);
  }
  return sums;
}

float ContactTerm::energy(const SearchPose& pose, float bound) const {
  Product alone{Levels::Ones(growth_.size())};
  std::vector<Residual> sharing;
  if (!groups_.empty()) sharing.resize(contacts_.size());
  Product least = alone;  // with contacts as near as their offset may bring them
  Located next = contacts_.empty() ? Located{} : located(contacts_.front(), pose);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Located here = next;
    if (k + 1 < contacts_.size()) next = located(contacts_[k + 1], pose);
    if (is_candidate(k)) continue;
    const Residual residual = residual_at(contacts_[k], pose, here);
    const Levels factor = likelihood(k, residual, contacts_[k].reach * residual.slope.norm());
    least.multiply(factor);
    if (const float sum = least.energy(priors_); sum > bound) return sum;
    if (groups_.empty()) continue;
    if (shares(k)) {
      sharing[k] = residual;
    } else {
      alone.multiply(factor);
    }
  }
  for (const CandidateSet& set : sets_) {
    const Levels factor = likelihood(set, pose);
    least.multiply(factor);
    if (const float sum = least.energy(priors_); sum > bound) return sum;
    alone.multiply(factor);
  }
  if (groups_.empty()) return least.energy(priors_);
  const Levels sums = level_energies(alone, sharing);
  const float lowest = sums.minCoeff();
  return lowest - std::log((lowest - sums).exp().sum());
}

Eigen::Index ContactTerm::likeliest_level(const SearchPose& pose,
                                          const std::vector<Residual>& residuals) const {
  Product alone{Levels::Ones(growth_.size())};
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    if (!shares(k) && !is_candidate(k)) alone.multiply(likelihood(k, residuals[k], 0));
  }
  for (const CandidateSet& set : sets_) alone.multiply(likelihood(set, pose));
  Eigen::Index best = 0;
  level_energies(alone, residuals).minCoeff(&best);
  return best;
}

std::vector<float> ContactTerm::distances_at_best(const std::vector<Residual>& residuals,
                                                  Eigen::Index level) const {
  std::vector<float> distances;
  for (const Residual& residual : residuals) distances.push_back(distance_at(residual, level));
  for (const Group& group : groups_) {
    const Eigen::Vector3f offset = fit(group, residuals, level).offset;
    for (const std::size_t k : group.members) distances[k] += residuals[k].slope.dot(offset);
  }
  return distances;
}

void ContactTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  const std::vector<Residual> residuals = residuals_at(pose);
  const Eigen::Index level = likeliest_level(pose, residuals);
  const std::vector<float> distances = distances_at_best(residuals, level);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (shares(k)) continue;
    float others = 0;
    if (is_candidate(k)) {
      others = odds(sets_[static_cast<std::size_t>(contacts_[k].set)], residuals, level) -
               odds(k, residuals[k], distances[k], level);
    }
    const auto contact = linearized(k, pose, distances[k], level, others);
    if (contact) equations.add(contact->J, contact->r, contact->weight);
  }
  for (const Group& group : groups_) {  // the offset is eliminated by its Schur complement
    Eigen::Matrix3d H = Eigen::Matrix3d::Identity() * static_cast<double>(group.precision);
    Eigen::Vector3d g =
        static_cast<double>(group.precision) * fit(group, residuals, level).offset.cast<double>();
    Eigen::Matrix<double, 6, 3> across = Eigen::Matrix<double, 6, 3>::Zero();
    for (const std::size_t k : group.members) {
      const auto contact = linearized(k, pose, distances[k], level);
      if (!contact) continue;
      equations.add(contact->J, contact->r, contact->weight);
      const double scale =
          std::sqrt(2 * static_cast<double>(noise_[k].half_point_precision[level]));
      const Eigen::Vector3d slope = scale * residuals[k].slope.cast<double>();
      H += contact->weight * slope * slope.transpose();
      g += contact->weight * contact->r[0] * slope;
      across += contact->weight * contact->J.row(0).transpose() * slope.transpose();
    }
    const Eigen::Matrix3d inverse = H.inverse();
    equations.H -= across * inverse * across.transpose();
    equations.g -= across * inverse * g;
  }
}

std::optional<ContactTerm::Linearized> ContactTerm::linearized(std::size_t k,
                                                               const SearchPose& pose,
                                                               float distance, Eigen::Index level,
                                                               float others) const {
  const Datum& contact = contacts_[k];
  const Eigen::Vector3f arm = contact.raised - pose.t;
  const Eigen::Matrix3f to_object = pose.R.transpose();
  const Eigen::Vector3f y = to_object * arm;
  const auto here = field_.at(y);
  if (!here || here->gradient.norm() < kShortestGradient) return std::nullopt;
  const LevelNoise noise = noise_at(k, level, here->squared_curvature);
  const Eigen::Vector3f m = here->gradient.normalized(), n = to_object * contact.n;
  Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero();  // of the distance
  for (int axis = 0; axis < 3; ++axis) {
    const auto beside = field_.at(y + kCurvatureStep * Eigen::Vector3f::Unit(axis));
    if (!beside || beside->gradient.norm() < kShortestGradient) continue;
    curvature.col(axis) = (beside->gradient.normalized() - m) / kCurvatureStep;
  }
  Eigen::Matrix<float, 3, 6> dy;  // of the point in the object's frame by [w; v]
  dy << to_object * skew(arm.cast<double>()).cast<float>(), -to_object;
  const float point_scale = std::sqrt(2 * noise.half_point_precision);
  const NormalFit normal = normal_fit(k, 0.5F * noise.normal_precision * (m - n).squaredNorm());
  const float normal_scale = std::sqrt(noise.normal_precision * normal.precision);
  Eigen::Matrix<float, 4, 6> J;
  J.row(0) = point_scale * m.transpose() * dy;
  J.bottomRows<3>() = normal_scale * curvature * dy;
  J.bottomLeftCorner<3, 3>() -=
      normal_scale * to_object * skew(contact.n.cast<double>()).cast<float>();
  Eigen::Vector4f r;
  r << point_scale * distance, normal_scale * (m - n);
  const double q = static_cast<double>(0.5F * r[0] * r[0] - std::log(normal.density));
  const double odds = static_cast<double>(noise.odds) * std::exp(-q);
  const double rest = 1 + static_cast<double>(others);
  const double weight = std::max(odds / (rest + odds), kMinTrust / (rest + q));
  return Linearized{J.cast<double>(), r.cast<double>(), weight};
}

float ContactTerm::misfit(const SearchPose& pose) const {
  float stated = 0, greatest = 0;
  for (std::size_t k = 0; k < noise_.size(); ++k) {
    if (is_candidate(k)) continue;
    stated += noise_[k].stated_cap;
    greatest += noise_[k].cap;
  }
  for (const CandidateSet& set : sets_) {
    stated += set.stated_cap;
    greatest += set.cap;
  }
  return (energy(pose, kNoBound) - (greatest - stated)) / stated;
}

int ContactTerm::unexplained(const SearchPose& pose) const {
  const std::vector<Residual> residuals = residuals_at(pose);
  const Eigen::Index level = likeliest_level(pose, residuals);
  const std::vector<float> distances = distances_at_best(residuals, level);
  int count = 0;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    count += !is_candidate(k) && odds(k, residuals[k], distances[k], level) < 1;
  }
  for (const CandidateSet& set : sets_) count += odds(set, residuals, level) < 1;
  return count;
}

}  // namespace palpate::localization
