// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/likelihood/evidence_term.hpp"
#include "palpate/core/random.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// The object rests on the table: a prior that can be both evaluated and drawn from.
///
/// E = min over stable poses s of (1 - u.u_s) / tilt^2 + (z - z_s)^2 / 2 height^2 - ln w_s, u being
/// the table's up in the object's frame, plus a box with Gaussian edges in x and y.
class TableTerm : public EvidenceTerm {
 public:
  TableTerm(const geometry::ObjectModel& model, const TableSupport& table);

  float energy(const SearchPose& pose, float bound) const override;
  void linearize(const SearchPose& pose, NormalEquations& equations) const override;
  SearchPose draw(RandomStream& random) const;

  /// ln of what scales e^-E to a density (per rad^3 m^3): E lacks the normal distributions' and the
  /// box's peaks, and the yaw's 1 / 2 pi.
  double log_peak() const;

 private:
  struct StablePose {
    Eigen::Matrix3d R_table_object;
    Eigen::Vector3f up;  // of the table, in the object's frame
    double height, weight;
    float minus_log_weight;
  };
  /// The stable pose that explains the pose best, with its part of the energy.
  struct Nearest {
    const StablePose* stable_pose;
    float energy;
  };
  Nearest nearest_stable_pose(const Eigen::Vector3f& up, float height) const;
  double draw_offset(RandomStream& random) const;

  TableSupport table_;
  Eigen::Vector3f origin_;
  Eigen::Matrix3f axes_;  // columns: x, y, z of the table in the evidence's frame
  std::vector<StablePose> stable_poses_;
};

}  // namespace palpate::localization
