// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "clearance.hpp"
#include "evidence_term.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Balls the object keeps out of: sum of max(0, r - phi(R'(c - t)))^2 / 2 (scale sigma)^2.
class FreeSpaceTerm : public EvidenceTerm {
 public:
  FreeSpaceTerm(const ObjectModel& model, const Evidence& evidence,
                std::shared_ptr<const Clearance> clearance, double scale);

  float energy(const SearchPose& pose, float bound) const override;

 private:
  struct Ball {
    Eigen::Vector3f center;
    float radius;
    float reach_squared;  // nearer than this to the object's origin it may touch the object
  };
  const geometry::DistanceField& field_;
  std::shared_ptr<const Clearance> clearance_;
  float half_precision_;
  std::vector<Ball> balls_;  // spread first, so that a wrong pose is soon found out
};

}  // namespace palpate::localization
