// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/resting_slack.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/objects/stable_poses.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::geometry {
namespace {

constexpr int kDirections = 16;      // of half a turn, each looked at to both sides
constexpr double kTrialLean = 0.04;  // rad, at which directions are compared
constexpr double kTurn = 1e-5;       // rad, to which the softest direction is found
/// Middles of four equally probable parts of the absolute value of a standard normal variable.
constexpr std::array<double, 4> kNormalQuantiles = {0.157, 0.489, 0.887, 1.534};

/// The corner that is lowest when that direction points up.
const Eigen::Vector3d& support(const std::vector<Eigen::Vector3d>& hull,
                               const Eigen::Vector3d& up) {
  return *std::ranges::min_element(hull, {}, [&](const Eigen::Vector3d& p) { return p.dot(up); });
}

/// Height of the centroid where that direction points up, m.
double height(const std::vector<Eigen::Vector3d>& hull, const Eigen::Vector3d& up) {
  return -support(hull, up).dot(up);
}

Eigen::Vector3d leaning(const Eigen::Vector3d& up, const Eigen::Vector3d& direction, double lean) {
  return std::cos(lean) * up + std::sin(lean) * direction;
}

/// The horizontal direction in which the centroid rises least, to both sides together.
Eigen::Vector3d softest_direction(const std::vector<Eigen::Vector3d>& hull,
                                  const Eigen::Vector3d& up) {
  const Eigen::Matrix3d frame = frame_with_z(up);
  const auto direction = [&](double angle) -> Eigen::Vector3d {
    return std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1);
  };
  const auto rise = [&](double angle) {
    return height(hull, leaning(up, direction(angle), kTrialLean)) +
           height(hull, leaning(up, direction(angle), -kTrialLean));
  };
  constexpr double kStep = std::numbers::pi / kDirections;
  double best = 0, lowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const double found = rise(i * kStep);
    if (found < lowest) {
      lowest = found;
      best = i * kStep;
    }
  }
  double low = best - kStep, high = best + kStep;
  while (high - low > kTurn) {
    const double third = (high - low) / 3;
    if (rise(low + third) < rise(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return direction((low + high) / 2);
}

}  // namespace

RestingSlack::Profile RestingSlack::profile(const std::vector<Eigen::Vector3d>& hull,
                                            const Eigen::Vector3d& up,
                                            const Eigen::Vector3d& direction) {
  const double flat = height(hull, up);
  Profile profile;
  for (std::size_t i = 0; i < kLeans.size(); ++i) {
    std::array<double, 2> at;  // of the support, along the direction
    for (std::size_t side = 0; side < 2; ++side) {
      const Eigen::Vector3d tilted = leaning(up, direction, side == 0 ? -kLeans[i] : kLeans[i]);
      const Eigen::Vector3d& found = support(hull, tilted);
      at[side] = found.dot(direction);
      profile.sides[side][i] = -found.dot(tilted) - flat;
    }
    profile.half_widths[i] = std::abs(at[1] - at[0]) / 2;
  }
  const double barrier = StablePoseOptions{}.barrier;  // the facets of a round side are lower
  for (Rises& rises : profile.sides) {
    for (std::size_t i = kLeans.size() - 1; i-- > 0;) {
      if (std::max(rises[i], rises[i + 1]) < barrier) rises[i] = std::min(rises[i], rises[i + 1]);
    }
  }
  return profile;
}

RestingSlack::RestingSlack(const std::vector<Eigen::Vector3d>& hull, const StablePose& pose) {
  const Eigen::Vector3d up = pose.R_table_object.row(2).transpose();
  directions_[0] = softest_direction(hull, up);
  directions_[1] = up.cross(directions_[0]);
  for (std::size_t i = 0; i < 2; ++i) profiles_[i] = profile(hull, up, directions_[i]);
}

/// Errors of two points at a distance of d have the covariance exp(-d^2 / 8 l^2): that of half the
/// distance, so that the slope, with half the difference, is the error over l.
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

double RestingSlack::lean_of_centroid(const Rises& rises, double sigma) {
  double squares = 0;
  for (const double quantile : kNormalQuantiles) {
    double lean = 0, rise = 0;
    for (std::size_t i = 0; i < kLeans.size(); ++i) {
      if (rises[i] - rise >= quantile * sigma * (kLeans[i] - lean)) break;
      lean = kLeans[i];
      rise = rises[i];
    }
    squares += lean * lean;
  }
  return std::sqrt(squares / static_cast<double>(kNormalQuantiles.size()));
}

double RestingSlack::lean_to(int side, int direction, double surface_sigma,
                             double centroid_sigma) const {
  const Profile& profile = profiles_[static_cast<std::size_t>(direction)];
  const Rises& rises = profile.sides[static_cast<std::size_t>(side)];
  const double of_centroid = centroid_sigma > 0 ? lean_of_centroid(rises, centroid_sigma) : 0;
  return std::min(std::hypot(lean_of_surface(profile, surface_sigma), of_centroid), kLeans.back());
}

double RestingSlack::lean(int direction, double surface_sigma, double centroid_sigma) const {
  const Profile& profile = profiles_[static_cast<std::size_t>(direction)];
  double squares = 0;  // of the centroid's leans
  for (const Rises& rises : profile.sides) {
    if (centroid_sigma > 0) squares += std::pow(lean_of_centroid(rises, centroid_sigma), 2);
  }
  const double of_surface = lean_of_surface(profile, surface_sigma);
  return std::min(std::hypot(of_surface, std::sqrt(squares / 2)), kLeans.back());
}

}  // namespace palpate::geometry
