// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/lanes.hpp"
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
  /// Four balls, one in each lane.
  struct FourBalls {
    std::array<Floats4, 3> center;
    Floats4 radius, reach_squared;
  };
  /// What all noise scales share: the balls, spread first, so that a wrong pose is soon found out.
  struct Balls {
    Balls(const geometry::ObjectModel& model, const Evidence& evidence);
    std::vector<Ball> balls;
    std::vector<FourBalls> fours;  // the same; the last are filled up with what is never reached
  };

  FreeSpaceTerm(const geometry::ObjectModel& model, const Evidence& evidence,
                std::shared_ptr<const Balls> balls, double scale);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;

 private:
  /// Balls as they lie at a pose, and which of them may touch the object.
  struct Batch {
    static constexpr std::size_t kSize = 32;
    std::array<Floats4, kSize / 4> x, y, z, arm_squared;  // in the object's frame; of its origin
    std::array<std::size_t, kSize> near;
    std::size_t near_count;
    Eigen::Vector3f center(std::size_t i) const { return {of(x, i), of(y, i), of(z, i)}; }
    static float of(const std::array<Floats4, kSize / 4>& lanes, std::size_t i) {
      return lanes[i / 4][static_cast<int>(i % 4)];
    }
  };
  /// @param first  of the balls of the batch, a multiple of its size
  void place(const SearchPose& pose, std::size_t first, Batch& batch) const;
  float distance_at(const Eigen::Vector3f& center, const geometry::DistanceField::Cell& cell) const;

  const geometry::DistanceField& field_;
  const geometry::Clearance& clearance_;
  std::shared_ptr<const Balls> shared_;
  float variance_, growth_variance_;  // of a depth: m^2, and per m^2 from the object's origin
  std::size_t count_;                 // of the balls that are looked at
};

}  // namespace palpate::localization
