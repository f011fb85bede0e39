// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "localization/likelihood/evidence_term.hpp"
#include "localization/likelihood/search_pose.hpp"
#include "palpate/core/random.hpp"
#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// Sum of the components' weights.
double total_weight(const PosePrior& prior);

/// A prior's mixture of normal distributions without its floor, prepared for many evaluations.
///
/// Component i at a pose: N_i = exp(-|L_i^-1 x|^2 / 2) / ((2 pi)^3 det L_i), where
/// x = [log(R R_i'); t - t_i] and L_i is the Cholesky factor of its covariance.
class PoseMixture {
 public:
  explicit PoseMixture(const PosePrior& prior);

  /// sum_i w_i N_i relative to the greatest w_i N_i(0); what lies beyond 8 sigma is left out.
  double relative_density(const SearchPose& pose) const;

  /// Adds the model of -ln(relative_density + floor) about the pose.
  void linearize(const SearchPose& pose, double floor, NormalEquations& equations) const;

  /// ln of that greatest w_i N_i(0) per rad^3 m^3, the weights scaled to sum to 1.
  double log_peak() const { return log_peak_; }

  /// The components' peaks together, relative to the greatest: no density is above.
  double highest() const { return highest_; }

  SearchPose draw(RandomStream& random) const;

 private:
  using Matrix6f = Eigen::Matrix<float, 6, 6>;
  struct Component {
    Eigen::Quaternionf q;
    Eigen::Vector3f t;
    float min_cosine = 0;    // of half the angle to a pose that matters
    float max_distance = 0;  // to such a pose, squared, m^2
    Matrix6f whitening;      // L^-1
    float peak = 0;          // relative to the greatest
    double share = 0;        // of the draws
    Matrix6d factor;         // L
  };

  /// L^-1 x of a component, nothing beyond its reach.
  static std::optional<Eigen::Matrix<float, 6, 1>> whitened(const Component& component,
                                                            const Eigen::Quaternionf& q,
                                                            const Eigen::Vector3f& t);

  std::vector<Component> components_;
  double log_peak_ = 0;
  double highest_ = 0;
};

}  // namespace palpate::localization
