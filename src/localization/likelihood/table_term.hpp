// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "localization/likelihood/evidence_term.hpp"
#include "palpate/core/random.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// The object rests on the table: a prior that can be both evaluated and drawn from.
///
/// E = min over stable poses s of sum_i (a_i / sigma_i)^2 / 2 + (z - z_s)^2 / 2 height^2 - ln w_s,
/// plus a box with Gaussian edges in x and y. The lean a (rad) is the rotation vector from u_s to
/// the table's up in the object's frame, along two directions; sigma_i consists of the tilt's
/// standard deviation and how far errors of the surface and the centre of mass make the object
/// lean. Where it leans farther to one side than to the other, its density is to that side the
/// larger one of both sides' normal distributions, each with its own peak.
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
  /// In one of the two directions in which it leans.
  struct Lean {
    Eigen::Vector3d direction;           // object's frame
    double sigma, far_sigma;             // rad, to the side where it leans less, and to the other
    bool far_along;                      // the other side is that of the direction
    float minus_log_far;                 // -ln of the peak to that side, relative to the other
    Eigen::Vector3f scaled, far_scaled;  // direction over either sigma

    /// Whether the density at a lean is that of the side where it leans farther.
    /// @param square_over_sine  of the whole lean
    bool is_far(const Eigen::Vector3f& table_up, float square_over_sine) const;
    /// A turn of the object by which the table's up leans against the direction, rad.
    double draw(RandomStream& random) const;
    /// Mass of the density, relative to a normal distribution's of the same peak and sigma.
    double mass() const;
  };
  struct StablePose {
    Eigen::Matrix3d R_table_object;
    Eigen::Vector3f up;  // of the table, in the object's frame
    double height, weight;
    float minus_log_weight;  // with the density's factor of its leans
    std::array<Lean, 2> leans;

    /// Of the sum of squares of the leans over their sigmas, half.
    float lean_energy(const Eigen::Vector3f& table_up) const;
  };
  /// The stable pose that explains the pose best, with its part of the energy.
  struct Nearest {
    const StablePose* stable_pose;
    float energy;
  };
  Nearest nearest_stable_pose(const Eigen::Vector3f& up, float height) const;
  double draw_offset(RandomStream& random) const;

  StablePose stable_pose(const geometry::ObjectModel& model, std::size_t number,
                         double weight) const;

  TableSupport table_;
  double height_sigma_;
  Eigen::Vector3f origin_;
  Eigen::Matrix3f axes_;  // columns: x, y, z of the table in the evidence's frame
  std::vector<StablePose> stable_poses_;
};

}  // namespace palpate::localization
