// SPDX-License-Identifier: Apache-2.0
#include "registration/rotation_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"
#include "registration/clock.hpp"

namespace palpate::registration {
namespace {

/// Two directions that a rotation should bring within an angle of one another.
struct Bearing {
  Eigen::Vector3d from, to;    // unit
  double angle, cosine, sine;  // of the angle, rad, at most pi
};

/// Of differences a and b: |R a - b| <= reach where their directions part by at most the angle.
Bearing bearing_of(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double reach) {
  constexpr double kRounding = 1e-9;
  const double product = 2 * a.norm() * b.norm();
  const double excess = a.squaredNorm() + b.squaredNorm() - reach * reach;
  if (!(product > 0) || excess <= -product) {  // any rotation will do
    return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitX(), std::numbers::pi, -1, 0};
  }
  const double angle = std::acos(std::min(1.0, excess / product)) + kRounding;
  return {a.normalized(), b.normalized(), angle, std::cos(angle), std::sin(angle)};
}

/// A cube of rotation vectors, and the bearings that some rotation in it may meet.
struct Cube {
  Eigen::Vector3d center;
  double half_side;
  std::vector<int> possible;
};

class CubeSearch {
 public:
  CubeSearch(std::vector<Bearing> bearings, int enough, Budget& budget)
      : bearings_(std::move(bearings)),
        enough_(static_cast<std::size_t>(enough)),
        budget_(budget) {}

  bool meets_enough(const Eigen::Vector3d& r) const {
    const Eigen::Matrix3d R = exp_so3(r);
    return std::ranges::count_if(bearings_, [&](const Bearing& b) {
             return meets(R, b, Slack(0));
           }) >= static_cast<std::ptrdiff_t>(enough_);
  }

  /// @return whether a rotation in the cube may meet enough; `witness` is one that does, if found
  bool may_meet(const Cube& cube, std::optional<Eigen::Vector3d>& witness) {
    if (!budget_.spend()) return true;
    std::vector<Cube> parts;
    for (int octant = 0; octant < 8; ++octant) {
      if (auto part = part_of(cube, octant, witness)) parts.push_back(std::move(*part));
      if (witness) return true;
    }
    std::ranges::sort(parts, std::greater<>(),
                      [](const Cube& part) { return part.possible.size(); });
    return std::ranges::any_of(parts, [&](const Cube& part) { return may_meet(part, witness); });
  }

 private:
  /// An angle that bearings may be missed by.
  struct Slack {
    explicit Slack(double a) : angle(a), cosine(std::cos(a)), sine(std::sin(a)) {}
    double angle, cosine, sine;
  };

  static bool meets(const Eigen::Matrix3d& R, const Bearing& b, const Slack& slack) {
    if (b.angle + slack.angle >= std::numbers::pi) return true;
    return b.to.dot(R * b.from) >= b.cosine * slack.cosine - b.sine * slack.sine;
  }

  /// One eighth of a cube, if it holds rotations and may meet enough.
  std::optional<Cube> part_of(const Cube& cube, int octant,
                              std::optional<Eigen::Vector3d>& witness) const {
    Cube part{cube.center, cube.half_side / 2, {}};
    for (int axis = 0; axis < 3; ++axis) {
      part.center[axis] += (octant >> axis & 1 ? 1 : -1) * part.half_side;
    }
    const Slack diagonal(std::numbers::sqrt3 * part.half_side), none(0);
    if (part.center.norm() - diagonal.angle > std::numbers::pi) return std::nullopt;
    const Eigen::Matrix3d R = exp_so3(part.center);
    std::size_t met = 0;
    for (const int i : cube.possible) {
      const Bearing& bearing = bearings_[static_cast<std::size_t>(i)];
      if (!meets(R, bearing, diagonal)) continue;
      part.possible.push_back(i);
      met += meets(R, bearing, none);
    }
    if (met >= enough_) witness = part.center;
    if (part.possible.size() < enough_) return std::nullopt;
    return part;
  }

  std::vector<Bearing> bearings_;
  std::size_t enough_;
  Budget& budget_;
};

}  // namespace

bool Budget::spend() {
  constexpr int kClockEvery = 64;
  if (used >= nodes || (used % kClockEvery == 0 && is_late())) is_spent = true;
  if (!is_spent) ++used;
  return !is_spent;
}

bool Budget::is_late() {
  const bool late = now() > deadline;
  is_spent = is_spent || late;
  return late;
}

bool RotationBound::can_have(int pivot, const std::vector<int>& others, int inliers,
                             std::optional<Eigen::Vector3d>& witness, Budget& budget) const {
  const auto at = static_cast<std::size_t>(pivot);
  std::vector<Bearing> bearings;
  Cube all{Eigen::Vector3d::Zero(), std::numbers::pi, {}};
  for (const int j : others) {
    const auto other = static_cast<std::size_t>(j);
    all.possible.push_back(static_cast<int>(bearings.size()));
    bearings.push_back(bearing_of(correspondences_.source[other] - correspondences_.source[at],
                                  correspondences_.target[other] - correspondences_.target[at],
                                  reach_));
  }
  if (static_cast<int>(bearings.size()) < inliers) return false;
  CubeSearch search(std::move(bearings), inliers, budget);
  if (witness && search.meets_enough(*witness)) return true;
  witness.reset();
  return search.may_meet(all, witness);
}

}  // namespace palpate::registration
