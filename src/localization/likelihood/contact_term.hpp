// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "localization/likelihood/contact_likelihood.hpp"
#include "localization/likelihood/evidence_term.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Contacts (p, n) with the surface, each with its own noise, some share of them false.
///
/// With y = R'(p + d n - t), a = phi(y) - d and m = R grad phi: q = a^2 / 2 sp^2 + (1 - n.m) / sn^2
/// (Gaussian distance, von Mises-Fisher normal), where the point's error turns the normal of a
/// surface of curvature c besides: sn^2 + c^2 sp^2 in the place of sn^2. E = ln[(1 + A) / (1 + A
/// e^-q)], where A = (1 - eps) / eps p_true(q = 0) / p_false, a false contact being uniform over a
/// litre and all directions. `scale` multiplies the noise. Of the true contacts a share s, by the
/// prior of the noise's scale, has a normal that is an outlier, sn^2 being nine times as large:
/// e^-q is a mixture of both. A contact without a normal is compared at the surface itself (d = 0)
/// and has no second term. Of a group of m candidates the odds A e^-q are averaged: 1 + sum A e^-q
/// / m.
///
/// An offset b ~ N(0, so^2 I) that contacts share makes it a_k + m_k.b, and is integrated out by
/// Laplace's method: E = sum E_k(b*) + |b*|^2 / 2 so^2 + ln det(I + so^2 sum w_k m_k m_k' / sp^2) /
/// 2, w_k being the probability that the contact is a true one.
/// The likelihood is a mixture over hypotheses that are the same for all contacts: the noise is
/// that stated or another one, the object as large as its mesh or larger by g. The latter makes
/// a_k + g (phi - y.grad phi) of it, as a field phi(y / (1 + g)) (1 + g) is to first order.
class ContactTerm : public EvidenceTerm {
 public:
  ContactTerm(const geometry::ObjectModel& model, const Evidence& evidence, double offset,
              double scale);

  float energy(const SearchPose& pose, float bound) const override;

  /// Residuals [a / sp; (m - n) / sn] of every contact, weighted by the probability that it is a
  /// true one: A e^-q / (1 + A e^-q); at the level of noise that explains the contacts best.
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

  /// Of a contact by itself, at the noise stated and without its offset.
  float contact_energy(std::size_t contact, const SearchPose& pose) const;

  /// Contacts that at this pose are more likely false than true.
  int unexplained(const SearchPose& pose) const;

  /// Energy of a pose above that of contacts that fit exactly at the noise stated, as a share of
  /// what it would be if no contact were explained. A little below 0 where less noise than stated
  /// explains them better.
  float misfit(const SearchPose& pose) const;

  /// ln of the greatest ratio of the contacts' likelihood to that of contacts that are all false:
  /// what the energy lacks to compare objects, or noise of one size with noise of another.
  double log_peak() const;

  /// Contacts, a set of candidates counting as one.
  std::size_t size() const;

 private:
  struct Datum {
    Eigen::Vector3f raised;  // the contact's point moved out along its normal
    Eigen::Vector3f n;
    Eigen::Matrix3f R_offset_frame = Eigen::Matrix3f::Identity();
    float reach = 0;   // of the offset it shares; 0: it shares none
    float offset = 0;  // distance from the surface at which it is compared
    int set = -1;      // of candidates that it is one of
  };
  using Noise = NoiseLevels;
  using Levels = NoiseArray;
  /// Of a contact at one level.
  struct LevelNoise {
    float half_point_precision, normal_precision, odds;
  };
  /// How a contact's normal fits: its density, relative to the peak of those that are no outliers,
  /// and precision, relative to theirs.
  struct NormalFit {
    float density, precision;
  };
  /// Contacts that share an offset.
  struct Group {
    float precision;  // 1 / so^2
    std::vector<std::size_t> members;
  };
  /// A contact as it lies at a pose.
  struct Residual : ContactPlace {
    Eigen::Vector3f slope = Eigen::Vector3f::Zero();  // of `distance` by the offset
    bool near = false;                                // within reach of the distance field
  };
  /// Where a contact is in the object's frame.
  struct Located {
    Eigen::Vector3f y;
    geometry::DistanceField::Cell cell;
  };
  /// An offset and the information about it.
  struct Fit {
    Eigen::Vector3f offset = Eigen::Vector3f::Zero();
    Eigen::Matrix3f information = Eigen::Matrix3f::Identity();
  };
  /// The residuals of a contact and their change with pose and offset.
  struct Linearized {
    Eigen::Matrix<double, 4, 6> J;
    Eigen::Vector4d r;
    double weight;
  };
  /// The product over contacts of their likelihoods at each level: one logarithm for all.
  struct Product {
    Levels likelihood;
    float log_scale = 0;
    void multiply(const Levels& factor);
    float energy(const Levels& priors) const {
      return -log_scale - std::log((priors * likelihood).sum());
    }
  };

  /// Candidates of which at least one touches. The caps are of all members at the surface at once,
  /// which bounds the likelihood; `stated_cap` of the most informative one.
  struct CandidateSet {
    std::vector<std::size_t> members;
    float cap = 0, inverse_peak = 0, stated_cap = 0;
  };

  bool shares(std::size_t contact) const { return contacts_[contact].reach > 0; }
  bool is_candidate(std::size_t contact) const { return contacts_[contact].set >= 0; }
  void gather_sets(const Evidence& evidence);
  /// @param squared_curvature  of the surface where the contact is
  LevelNoise noise_at(std::size_t k, Eigen::Index level, float squared_curvature) const {
    const float wider = 1 + noise_[k].curvature_widening[level] * squared_curvature;
    return {noise_[k].half_point_precision[level], noise_[k].normal_precision[level] / wider,
            noise_[k].odds[level] / wider};
  }
  /// @param q  (1 - n.m) / sn^2
  NormalFit normal_fit(std::size_t contact, float q) const;
  Located located(const Datum& contact, const SearchPose& pose) const {
    const Eigen::Vector3f y = pose.R.transpose() * (contact.raised - pose.t);
    return {y, field_.fetched(y)};
  }
  Residual residual_at(const Datum& contact, const SearchPose& pose, const Located& at) const;
  Residual residual_at(const Datum& contact, const SearchPose& pose) const {
    return residual_at(contact, pose, located(contact, pose));
  }
  std::vector<Residual> residuals_at(const SearchPose& pose) const;
  float distance_at(const Residual& residual, Eigen::Index level) const {
    return residual.distance + growth_[level] * residual.scale_derivative;
  }
  /// Likelihood of a contact at every level, at most 1; `slack` nearer than it lies.
  Levels likelihood(std::size_t contact, const Residual& residual, float slack) const;
  /// The same of a set.
  Levels likelihood(const CandidateSet& set, const SearchPose& pose) const;
  /// Odds that a contact is a true one, A e^-q.
  float odds(std::size_t contact, const Residual& residual, float distance,
             Eigen::Index level) const;
  float contact_energy(std::size_t contact, const Residual& residual, float distance,
                       Eigen::Index level) const;
  /// Odds that some candidate of a set is a true contact, sum of A e^-q.
  float odds(const CandidateSet& set, const std::vector<Residual>& residuals,
             Eigen::Index level) const;
  Fit fit(const Group& group, const std::vector<Residual>& residuals, Eigen::Index level) const;
  float group_energy(const Group& group, const std::vector<Residual>& residuals,
                     Eigen::Index level) const;
  /// Of all contacts, given the product of those that share no offset.
  Levels level_energies(const Product& alone, const std::vector<Residual>& residuals) const;
  Eigen::Index likeliest_level(const SearchPose& pose,
                               const std::vector<Residual>& residuals) const;
  /// Of every contact, displaced by the offset that fits best.
  std::vector<float> distances_at_best(const std::vector<Residual>& residuals,
                                       Eigen::Index level) const;
  /// @param others  odds of the other candidates of its set
  std::optional<Linearized> linearized(std::size_t contact, const SearchPose& pose, float distance,
                                       Eigen::Index level, float others = 0) const;

  const geometry::DistanceField& field_;
  std::vector<Datum> contacts_;
  std::vector<CandidateSet> sets_;
  std::vector<Group> groups_;
  float max_growth_ = 0;
  Levels priors_, growth_;  // probability, relative growth of the object
  std::vector<Noise> noise_;
};

}  // namespace palpate::localization
