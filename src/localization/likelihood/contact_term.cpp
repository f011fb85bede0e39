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

constexpr float kStray = 9;  // times the variance of normals, there

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
  const std::vector<Assumption> levels = assumptions(evidence);
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
    for (const std::size_t k : members) {
      Noise& noise = noise_[k];
      noise.odds /= count;
      contacts_[k].set = static_cast<int>(sets_.size());
      set.cap = std::max(set.cap, std::log1p(noise.odds.maxCoeff()));
      set.stated_cap = std::max(set.stated_cap, std::log1p(noise.odds[0]));
    }
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

float ContactTerm::Product::energy(const Levels& priors) const {
  return -log_scale - std::log((priors * likelihood).sum());
}

ContactTerm::NormalFit ContactTerm::normal_fit(std::size_t k, float q) const {
  const float stray = noise_[k].stray;
  const float near = (1 - stray) * std::exp(-q);
  const float far = stray / kStray * std::exp(-q / kStray);
  const float density = std::max(near + far, std::numeric_limits<float>::min());
  return {density, stray > 0 ? (near + far / kStray) / density : 1};
}

ContactTerm::Felt ContactTerm::feel(const Datum& contact, const SearchPose& pose) const {
  Felt felt;
  const Eigen::Vector3f y = pose.R.transpose() * (contact.raised - pose.t);
  const auto sample = field_.at(y);
  if (!sample) return felt;
  felt.near = true;
  felt.squared_curvature = sample->squared_curvature;
  felt.away = sample->distance - contact.offset;
  const float length = std::max(kShortestGradient, sample->gradient.norm());
  felt.tilt = 1 - (pose.R.transpose() * contact.n).dot(sample->gradient) / length;
  felt.swell = sample->distance - y.dot(sample->gradient) / length;
  if (contact.reach > 0) felt.slope = contact.R_offset_frame * (pose.R * sample->gradient) / length;
  return felt;
}

std::vector<ContactTerm::Felt> ContactTerm::feel_all(const SearchPose& pose) const {
  std::vector<Felt> felt;
  felt.reserve(contacts_.size());
  for (const Datum& contact : contacts_) felt.push_back(feel(contact, pose));
  return felt;
}

ContactTerm::Levels ContactTerm::likelihood(std::size_t k, const Felt& felt, float slack) const {
  const Noise& noise = noise_[k];
  const float min_away =
      std::max(0.0F, std::abs(felt.away) - max_growth_ * std::abs(felt.swell) - slack);
  const float min_q = min_away * min_away * noise.min_half_point_precision +
                      felt.tilt * noise.min_normal_precision / kStray /
                          (1 + noise.max_curvature_widening * felt.squared_curvature);
  if (!felt.near || min_q > kHopeless) {
    return Levels::Constant(growth_.size(), noise.inverse_peak);
  }
  Levels away = felt.away + growth_ * felt.swell;
  if (slack > 0) away = (away.abs() - slack).max(0.0F);
  const Levels wider = 1 + noise.curvature_widening * felt.squared_curvature;
  const Levels qn = felt.tilt * noise.normal_precision / wider;
  const Levels normal =
      (1 - noise.stray) * (-qn).exp() + noise.stray / kStray * (-qn / kStray).exp();
  return (1 + noise.odds / wider * normal * (-away.square() * noise.half_point_precision).exp()) *
         noise.inverse_peak;
}

ContactTerm::Levels ContactTerm::likelihood(const CandidateSet& set, const SearchPose& pose) const {
  Levels sum = Levels::Constant(growth_.size(), set.inverse_peak);
  for (const std::size_t k : set.members) {
    sum += likelihood(k, feel(contacts_[k], pose), 0) - set.inverse_peak;
  }
  return sum;
}

float ContactTerm::odds(std::size_t k, const Felt& felt, float away, Eigen::Index level) const {
  const LevelNoise noise = noise_at(k, level, felt.squared_curvature);
  const float q = away * away * noise.half_point_precision;
  if (!felt.near || q >= kHopeless) return 0;
  return noise.odds * std::exp(-q) * normal_fit(k, felt.tilt * noise.normal_precision).density;
}

float ContactTerm::odds(const CandidateSet& set, const std::vector<Felt>& felt,
                        Eigen::Index level) const {
  float sum = 0;
  for (const std::size_t k : set.members) sum += odds(k, felt[k], away_at(felt[k], level), level);
  return sum;
}

float ContactTerm::contact_energy(std::size_t k, const Felt& felt, float away,
                                  Eigen::Index level) const {
  return noise_[k].cap - std::log1p(odds(k, felt, away, level));
}

float ContactTerm::contact_energy(std::size_t k, const SearchPose& pose) const {
  const Felt felt = feel(contacts_[k], pose);
  return noise_[k].stated_cap - noise_[k].cap + contact_energy(k, felt, felt.away, 0);
}

/// Reweighted least squares. The first weights bear with a contact as far off as the offset may be.
ContactTerm::Fit ContactTerm::fit(const Group& group, const std::vector<Felt>& felt,
                                  Eigen::Index level) const {
  Fit fit;
  const float variance = 1 / group.precision;
  for (int step = 0; step < kFitSteps; ++step) {
    Eigen::Matrix3f H = group.precision * Eigen::Matrix3f::Identity();
    Eigen::Vector3f g = Eigen::Vector3f::Zero();
    for (const std::size_t k : group.members) {
      if (!felt[k].near) continue;
      const LevelNoise noise = noise_at(k, level, felt[k].squared_curvature);
      const float precision = 2 * noise.half_point_precision;
      const float away = away_at(felt[k], level) + felt[k].slope.dot(fit.offset);
      const float patience = step == 0 ? 1 + variance * precision : 1;
      const float q = away * away * noise.half_point_precision / patience;
      if (q >= kHopeless) continue;
      const float normal = normal_fit(k, felt[k].tilt * noise.normal_precision).density;
      const float odds = noise.odds * std::exp(-q) * normal;
      const float weight = odds / (1 + odds) * precision;
      H.noalias() += weight * felt[k].slope * felt[k].slope.transpose();
      g += weight * away_at(felt[k], level) * felt[k].slope;
    }
    fit.information = H;
    fit.offset = -H.inverse() * g;
  }
  return fit;
}

float ContactTerm::group_energy(const Group& group, const std::vector<Felt>& felt,
                                Eigen::Index level) const {
  const Fit best = fit(group, felt, level);
  float sum = 0.5F * group.precision * best.offset.squaredNorm() +
              0.5F * std::log(best.information.determinant() / std::pow(group.precision, 3.0F));
  for (const std::size_t k : group.members) {
    sum +=
        contact_energy(k, felt[k], away_at(felt[k], level) + felt[k].slope.dot(best.offset), level);
  }
  return sum;
}

ContactTerm::Levels ContactTerm::level_energies(const Product& alone,
                                                const std::vector<Felt>& felt) const {
  Levels sums = -priors_.log() - alone.likelihood.log() - alone.log_scale;
  for (const Group& group : groups_) {
    for (Eigen::Index j = 0; j < sums.size(); ++j) sums[j] += group_energy(group, felt, j);
  }
  return sums;
}

float ContactTerm::energy(const SearchPose& pose, float bound) const {
  Product alone{Levels::Ones(growth_.size())};
  std::vector<Felt> sharing;
  if (!groups_.empty()) sharing.resize(contacts_.size());
  Product least = alone;  // with contacts as near as their offset may bring them
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (is_candidate(k)) continue;
    const Felt felt = feel(contacts_[k], pose);
    const Levels factor = likelihood(k, felt, contacts_[k].reach * felt.slope.norm());
    least.multiply(factor);
    if (const float sum = least.energy(priors_); sum > bound) return sum;
    if (groups_.empty()) continue;
    if (shares(k)) {
      sharing[k] = felt;
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
                                          const std::vector<Felt>& felt) const {
  Product alone{Levels::Ones(growth_.size())};
  for (std::size_t k = 0; k < felt.size(); ++k) {
    if (!shares(k) && !is_candidate(k)) alone.multiply(likelihood(k, felt[k], 0));
  }
  for (const CandidateSet& set : sets_) alone.multiply(likelihood(set, pose));
  Eigen::Index best = 0;
  level_energies(alone, felt).minCoeff(&best);
  return best;
}

std::vector<float> ContactTerm::away_at_best(const std::vector<Felt>& felt,
                                             Eigen::Index level) const {
  std::vector<float> away;
  for (const Felt& contact : felt) away.push_back(away_at(contact, level));
  for (const Group& group : groups_) {
    const Eigen::Vector3f offset = fit(group, felt, level).offset;
    for (const std::size_t k : group.members) away[k] += felt[k].slope.dot(offset);
  }
  return away;
}

void ContactTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  const std::vector<Felt> felt = feel_all(pose);
  const Eigen::Index level = likeliest_level(pose, felt);
  const std::vector<float> away = away_at_best(felt, level);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    if (shares(k)) continue;
    float others = 0;
    if (is_candidate(k)) {
      others = odds(sets_[static_cast<std::size_t>(contacts_[k].set)], felt, level) -
               odds(k, felt[k], away[k], level);
    }
    const auto contact = linearized(k, pose, away[k], level, others);
    if (contact) equations.add(contact->J, contact->r, contact->weight);
  }
  for (const Group& group : groups_) {  // the offset is eliminated by its Schur complement
    Eigen::Matrix3d H = Eigen::Matrix3d::Identity() * static_cast<double>(group.precision);
    Eigen::Vector3d g =
        static_cast<double>(group.precision) * fit(group, felt, level).offset.cast<double>();
    Eigen::Matrix<double, 6, 3> across = Eigen::Matrix<double, 6, 3>::Zero();
    for (const std::size_t k : group.members) {
      const auto contact = linearized(k, pose, away[k], level);
      if (!contact) continue;
      equations.add(contact->J, contact->r, contact->weight);
      const double scale =
          std::sqrt(2 * static_cast<double>(noise_[k].half_point_precision[level]));
      const Eigen::Vector3d slope = scale * felt[k].slope.cast<double>();
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
                                                               const SearchPose& pose, float away,
                                                               Eigen::Index level,
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
  r << point_scale * away, normal_scale * (m - n);
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
  const std::vector<Felt> felt = feel_all(pose);
  const Eigen::Index level = likeliest_level(pose, felt);
  const std::vector<float> away = away_at_best(felt, level);
  int count = 0;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    count += !is_candidate(k) && odds(k, felt[k], away[k], level) < 1;
  }
  for (const CandidateSet& set : sets_) count += odds(set, felt, level) < 1;
  return count;
}

}  // namespace palpate::localization
