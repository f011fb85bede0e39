// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::geometry {

/// m over which the error of a scanned surface changes: its slope is the error over this.
constexpr double kSurfaceErrorLength = 0.006;

/// How far an object comes to rest from a stable pose of its mesh because the mesh or the centre of
/// mass is not exact.
///
/// At a lean t to a side the plane meets the hull at p(t) and the centroid is h(t) high. An object
/// rests where h is least. An error of the surface tilts a flat support by the error's difference
/// over the support's width, and rolls a round one, of radius r about the support, by the error's
/// slope times r / (r - h(0)): both where the mean of h(t) - h(0) over the two sides equals half
/// the error's difference between p(t) and p(-t). A centre of mass displaced by c rolls it to that
/// side to where h rises by c per radian. The facets of a tessellated round side stop nothing.
class RestingSlack {
 public:
  /// @param hull  corners of the mesh's convex hull in the object's frame, whose origin is the
  ///              volume centroid, m
  RestingSlack(const std::vector<Eigen::Vector3d>& hull, const StablePose& pose);

  /// Unit directions, in the object's frame, in which the plane's normal leans: the first where the
  /// centroid rises least, the second across it.
  const std::array<Eigen::Vector3d, 2>& directions() const { return directions_; }

  /// Standard deviation (rad, at most 0.64) of the lean in the first or the second direction.
  /// @param surface_sigma  m, error of the surface along its normal
  /// @param centroid_sigma  m, error of the centre of mass along each axis
  double lean(int direction, double surface_sigma, double centroid_sigma = 0) const;

  /// The same to one side, by the centre of mass (an error of the surface counts as to both): a
  /// handle on the table stops what rolls to that side, and not what rolls off it.
  /// @param side  0: against the direction, 1: along it
  double lean_to(int side, int direction, double surface_sigma, double centroid_sigma = 0) const;

 private:
  static constexpr std::array<double, 13> kLeans = {0.0025, 0.005, 0.01, 0.02, 0.03, 0.04, 0.06,
                                                    0.08,   0.12,  0.16, 0.24, 0.32, 0.64};  // rad
  using Rises = std::array<double, kLeans.size()>;  // of the centroid, m
  struct Profile {
    std::array<Rises, 2> sides;
    std::array<double, kLeans.size()> half_widths;  // m, half the distance of the two supports
  };
  static Profile profile(const std::vector<Eigen::Vector3d>& hull, const Eigen::Vector3d& up,
                         const Eigen::Vector3d& direction);
  static double lean_of_surface(const Profile& profile, double sigma);
  static double lean_of_centroid(const Rises& rises, double sigma);

  std::array<Eigen::Vector3d, 2> directions_;
  std::array<Profile, 2> profiles_;
};

}  // namespace palpate::geometry
