// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "geometry/query/clearance.hpp"
#include "localization/likelihood/evidence_term.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Balls the object keeps out of: sum of max(0, r - phi(R'(c - t)))^2 / 2 (scale sigma)^2. Enlarged
/// noise makes neighbours redundant, so that only some are looked at then, the most spread.
class FreeSpaceTerm : public EvidenceTerm {
 public:
  struct Ball {
    Eigen::Vector3f center;
    float radius;
    float reach_squared;  // nearer than this to the object's origin it may touch the object
  };
  /// What all noise scales share: the balls, spread first, so that a wrong pose is soon found out.
  struct Balls {
    Balls(const geometry::ObjectModel& model, const Evidence& evidence);
    std::vector<Ball> balls;
  };

  FreeSpaceTerm(const geometry::ObjectModel& model, const Evidence& evidence,
                std::shared_ptr<const Balls> balls, double scale);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

 private:
  const geometry::DistanceField& field_;
  const geometry::Clearance& clearance_;
  std::shared_ptr<const Balls> shared_;
  float variance_, growth_variance_;  // of a depth: m^2, and per m^2 from the object's origin
  std::size_t count_;                 // of the balls that are looked at
};

}  // namespace palpate::localization
