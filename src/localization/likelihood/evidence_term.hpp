// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "localization/likelihood/search_pose.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {

inline constexpr float kNoBound = std::numeric_limits<float>::infinity();

/// Gauss-Newton model of an energy about a pose (R, t): for R' = exp(w) R, t' = t + v it is about
/// E + g.x + x'Hx / 2, x = [w; v] (rad, m).
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();

  /// Adds `weight` r'r / 2 of residuals r with their Jacobian.
  template <class Jacobian, class Residual>
  void add(const Jacobian& J, const Residual& r, double weight) {
    H.noalias() += weight * J.transpose() * J;
    g.noalias() += weight * J.transpose() * r;
  }
};

/// One kind of evidence: its part of -ln p(evidence | pose), up to a constant.
class EvidenceTerm {
 public:
  virtual ~EvidenceTerm() = default;

  /// The energy of a pose. Above `bound` any value above it will do, so that terms may stop early.
  virtual float energy(const SearchPose& pose, float bound) const = 0;

  /// Adds the term's part to the model of the energy about the pose.
  virtual void linearize(const SearchPose& pose, NormalEquations& equations) const = 0;
};

/// The sum of all terms.
class Energy {
 public:
  void add(std::unique_ptr<EvidenceTerm> term) { terms_.push_back(std::move(term)); }

  float operator()(const SearchPose& pose, float bound = kNoBound) const {
    float sum = 0;
    for (const auto& term : terms_) {
      sum += term->energy(pose, bound - sum);
      if (sum > bound) break;
    }
    return sum;
  }

  NormalEquations linearized(const SearchPose& pose) const {
    NormalEquations equations;
    for (const auto& term : terms_) term->linearize(pose, equations);
    return equations;
  }

 private:
  std::vector<std::unique_ptr<EvidenceTerm>> terms_;
};

}  // namespace palpate::localization
