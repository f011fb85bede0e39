// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/resting_slack.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::geometry {
namespace {

constexpr int kDirections = 8;  // of half a turn, each looked at to both sides
/// Middles of four equally probable parts of the absolute value of a standard normal variable.
constexpr std::array<double, 4> kNormalQuantiles = {0.157, 0.489, 0.887, 1.534};

/// The corner that is lowest when that direction points up.
const Eigen::Vector3d& support(const std::vector<Eigen::Vector3d>& hull,
                               const Eigen::Vector3d& up) {
  return *std::ranges::min_element(hull, {}, [&](const Eigen::Vector3d& p) { return p.dot(up); });
}

}  // namespace

RestingSlack::Profile RestingSlack::profile(const std::vector<Eigen::Vector3d>& hull,
                                            const Eigen::Vector3d& up,
                                            const Eigen::Vector3d& direction) {
  const double flat = -support(hull, up).dot(up);
  Profile profile;
  for (std::size_t i = 0; i < kLeans.size(); ++i) {
    std::array<Eigen::Vector3d, 2> at;
    for (std::size_t side = 0; side < 2; ++side) {
      const double lean = side == 0 ? -kLeans[i] : kLeans[i];
      const Eigen::Vector3d leaning = std::cos(lean) * up + std::sin(lean) * direction;
      at[side] = support(hull, leaning);
      profile.sides[side][i] = -at[side].dot(leaning) - flat;
    }
    profile.half_widths[i] = (at[1] - at[0]).norm() / 2;
  }
  return profile;
}

RestingSlack::RestingSlack(const std::vector<Eigen::Vector3d>& hull, const StablePose& pose) {
  const Eigen::Vector3d up = pose.R_table_object.row(2).transpose();
  const Eigen::Matrix3d frame = frame_with_z(up);
  double lowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * i / kDirections;
    const Eigen::Vector3d direction =
        std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1);
    const Profile found = profile(hull, up, direction);
    const double rise = found.sides[0][5] + found.sides[1][5];
    if (rise >= lowest) continue;
    lowest = rise;
    directions_[0] = direction;
    profiles_[0] = found;
  }
  directions_[1] = up.cross(directions_[0]);
  profiles_[1] = profile(hull, up, directions_[1]);
}

/// Errors of two points that far apart: their covariance falls as exp(-d^2 / 2 l^2).
double RestingSlack::lean_of_surface(const Profile& profile, double sigma) {
  double lean = 0, missing = 0;  // by which the rise is below the error
  for (std::size_t i = 0; i < kLeans.size(); ++i) {
    const double apart = profile.half_widths[i] / kSurfaceErrorLength;
    const double error = sigma * std::sqrt((1 - std::exp(-apart * apart / 2)) / 2);
    const double rise = (profile.sides[0][i] + profile.sides[1][i]) / 2;
    if (rise >= error) {
      if (i == 0) return rise > 0 ? kLeans[0] * error / rise : 0;
      return lean + (kLeans[i] - lean) * missing / (missing + rise - error);
    }
    lean = kLeans[i];
    missing = error - rise;
  }
  return lean;
}

double RestingSlack::lean_of_centroid(const Profile& profile, double sigma) {
  double squares = 0;
  for (const Rises& rises : profile.sides) {
    for (const double quantile : kNormalQuantiles) {
      double lean = 0, rise = 0;
      for (std::size_t i = 0; i < kLeans.size(); ++i) {
        if (rises[i] - rise >= quantile * sigma * (kLeans[i] - lean)) break;
        lean = kLeans[i];
        rise = rises[i];
      }
      squares += lean * lean;
    }
  }
  return std::sqrt(squares / static_cast<double>(profile.sides.size() * kNormalQuantiles.size()));
}

double RestingSlack::lean(int direction, double surface_sigma, double centroid_sigma) const {
  const Profile& profile = profiles_[static_cast<std::size_t>(direction)];
  return std::hypot(lean_of_surface(profile, surface_sigma),
                    centroid_sigma > 0 ? lean_of_centroid(profile, centroid_sigma) : 0);
}

}  // namespace palpate::geometry
