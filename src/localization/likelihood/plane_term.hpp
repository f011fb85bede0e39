// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/likelihood/evidence_term.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// The object's lowest point along a plane's normal lies on the plane. For each plane
///
///   E = -ln((1 - m) N(d; 0, sigma^2) + m / L) + const,
///
/// d the height of the lowest corner of the object's hull over the plane, m the probability that
/// something else was met, at any of L metres of height.
class PlaneTerm : public EvidenceTerm {
 public:
  /// @param scale  of the noise
  PlaneTerm(const geometry::ObjectModel& model, const Evidence& evidence, double scale);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

 private:
  struct Plane {
    Eigen::Vector3f normal;
    float height, precision;  // m, 1 / sigma
    float missed;             // E where something else was met, over that of d = 0
  };
  struct Lowest {
    Eigen::Vector3f corner;  // turned into the evidence's frame
    float above;             // the plane, m
  };
  [[nodiscard]] Lowest lowest(const SearchPose& pose, const Plane& plane) const;

  const std::vector<Eigen::Vector3f>& hull_;
  std::vector<Plane> planes_;
};

}  // namespace palpate::localization
