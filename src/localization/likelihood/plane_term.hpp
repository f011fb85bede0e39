// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/likelihood/evidence_term.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// The object's lowest point along a plane's normal lies on the plane. For each plane
///
///   E = log_peak() - ln((1 - m) N(d; 0, sigma^2) + m / L), which is 0 at d = 0;
///
/// d the height of the lowest corner of the object's hull over the plane, m the probability that
/// something else was met, at any of L metres of height.
class PlaneTerm : public EvidenceTerm {
 public:
  /// @param scale  of the noise
  PlaneTerm(const geometry::ObjectModel& model, const Evidence& evidence, double scale);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;
  /// Of the highest likelihood, 1 / m for each plane.
  double log_peak() const { return log_peak_; }

 private:
  struct Plane {
    Eigen::Vector3f normal;
    float height, precision;  // m, 1 / sigma
    float missed;             // -ln of the density there, over that of contact at d = 0
  };
  struct Lowest {
    Eigen::Vector3f corner;  // turned into the evidence's frame
    float above;             // the plane, m
  };
  [[nodiscard]] Lowest lowest(const SearchPose& pose, const Plane& plane) const;

  const std::vector<Eigen::Vector3f>& hull_;
  std::vector<Plane> planes_;
  double log_peak_ = 0;
};

}  // namespace palpate::localization
