// SPDX-License-Identifier: Apache-2.0
#include "localization/search/free_axis_fit.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/angle.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

using std::numbers::pi;

constexpr double kMinTurn = 10 * kDegree;  // between two poses that determine an axis
constexpr double kMaxTurn = 120 * kDegree;
constexpr double kWidestGap = 12 * kDegree;  // between neighbours of one arc
constexpr double kMinExtent = 15 * kDegree;  // shorter arcs are left to a few balls
constexpr double kSpacing = 0.5 * kDegree;   // of poses that may be the centre of an arc
constexpr double kClearlyMore = 4.5;         // standard deviations of a count
constexpr std::size_t kHypotheses = 60, kScored = 300;
constexpr int kRefits = 2;

/// The line about which a pure rotation takes `a` nearest to `b`.
std::optional<FreeAxis> line_between(const PosePoint& a, const PosePoint& b) {
  const Eigen::AngleAxisd turn(b.q * a.q.conjugate());
  if (turn.angle() < kMinTurn || turn.angle() > kMaxTurn) return std::nullopt;
  const Eigen::Vector3d axis = turn.axis();
  const Eigen::Vector3d step = b.t - a.t;
  if (std::abs(step.dot(axis)) > PoseTolerance().translation) return std::nullopt;
  const Eigen::Vector3d across = step - step.dot(axis) * axis;
  const Eigen::Vector3d point =
      a.t + across / 2 + axis.cross(across) / (2 * std::tan(turn.angle() / 2));
  return FreeAxis{point, axis, pi};
}

std::vector<PosePoint> strided(const std::vector<PosePoint>& poses, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, poses.size() / most);
  std::vector<PosePoint> result;
  for (std::size_t i = 0; i < poses.size(); i += stride) result.push_back(poses[i]);
  return result;
}

std::optional<PoseFamily> best_line(const std::vector<PosePoint>& poses, const PosePoint& seed,
                                    const PoseFamily::Symmetries& symmetries) {
  const std::vector<PosePoint> scored = strided(poses, kScored);
  std::optional<PoseFamily> best;
  std::ptrdiff_t most = 0;
  for (const PosePoint& other : strided(poses, kHypotheses)) {
    const auto axis = line_between(seed, PoseFamily(seed).match(other, symmetries).image);
    if (!axis) continue;
    const PoseFamily family(seed, *axis);
    const auto held = std::count_if(scored.begin(), scored.end(), [&](const PosePoint& pose) {
      return family.contains(pose, symmetries);
    });
    if (held <= most) continue;
    most = held;
    best = family;
  }
  return best;
}

std::vector<PoseFamily::Match> matches_within(const PoseFamily& family,
                                              const std::vector<PosePoint>& poses,
                                              const PoseFamily::Symmetries& symmetries) {
  std::vector<PoseFamily::Match> result;
  for (const PosePoint& pose : poses) {
    if (!family.contains(pose, symmetries)) continue;  // most, at little cost
    auto match = family.match(pose, symmetries);
    if (relative_error(match.error) <= 1) result.push_back(std::move(match));
  }
  return result;
}

/// The axis to which the members' turns from the family's pose are closest.
Eigen::Vector3d fitted_direction(const PoseFamily& family,
                                 const std::vector<PoseFamily::Match>& members) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& member : members) {
    const Eigen::Vector3d v = (member.image.q * family.pose().q.conjugate()).vec();
    scatter += v * v.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Vector3d axis = solver.eigenvectors().col(2);
  return axis.dot(family.axis()->direction) < 0 ? -axis : axis;
}

/// The fixed point c of the members' turns: least squares on (I - R) c = t - R t0.
Eigen::Vector3d fitted_point(const PoseFamily& family, const Eigen::Vector3d& direction,
                             const std::vector<PoseFamily::Match>& members) {
  const auto count = static_cast<double>(members.size());
  // The equations leave c free along the axis, where it stays beside the pose.
  Eigen::Matrix3d H = count * direction * direction.transpose();
  Eigen::Vector3d g = H * family.pose().t;
  for (const auto& member : members) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(member.along, direction).toRotationMatrix();
    const Eigen::Matrix3d A = Eigen::Matrix3d::Identity() - R;
    H += A.transpose() * A;
    g += A.transpose() * (member.image.t - R * family.pose().t);
  }
  return H.ldlt().solve(g);
}

PoseFamily refitted(const PoseFamily& family, const std::vector<PoseFamily::Match>& members) {
  FreeAxis axis = *family.axis();
  axis.direction = fitted_direction(family, members);
  axis.point = fitted_point(family, axis.direction, members);
  std::vector<PosePoint> turned_back;
  for (const auto& member : members) {
    const Eigen::Quaterniond back(Eigen::AngleAxisd(-member.along, axis.direction));
    turned_back.emplace_back(back * member.image.q,
                             axis.point + back * (member.image.t - axis.point));
  }
  return {mean_pose(turned_back), axis};
}

/// The stretch of the circle that holds the most angles without a wide gap.
struct Arc {
  double middle = 0, extent = 0;
};
Arc fullest_arc(std::vector<double> angles) {
  std::sort(angles.begin(), angles.end());
  const std::size_t count = angles.size();
  for (std::size_t i = 0; i < count; ++i) angles.push_back(angles[i] + 2 * pi);
  Arc best;
  std::size_t most = 0;
  for (std::size_t first = 0, last = 0; first < count; first = last + 1, last = first) {
    while (last + 1 < first + count && angles[last + 1] - angles[last] < kWidestGap) ++last;
    const bool all_round =
        last + 1 == first + count && angles[last + 1] - angles[last] < kWidestGap;
    if (all_round) return {0, pi};
    if (last - first < most) continue;
    most = last - first;
    best = {(angles[first] + angles[last]) / 2, (angles[last] - angles[first]) / 2};
  }
  return best;
}

}  // namespace

PosePoint mean_pose(const std::vector<PosePoint>& poses) {
  const PosePoint& first = poses.front();
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), step = Eigen::Vector3d::Zero();
  for (const PosePoint& pose : poses) {
    turn += log_so3((pose.q * first.q.conjugate()).toRotationMatrix());
    step += pose.t - first.t;
  }
  const auto count = static_cast<double>(poses.size());
  return {Eigen::Quaterniond(exp_so3(turn / count)) * first.q, first.t + step / count};
}

PoseFamily centered_where_densest(const PoseFamily& family, const std::vector<PosePoint>& members,
                                  const PoseFamily::Symmetries& symmetries) {
  FreeAxis axis = *family.axis();
  // Of the whole circle, or what lies beyond the arc's ends would count as at them.
  const PoseFamily circle(family.pose(), {axis.point, axis.direction, pi});
  std::vector<double> angles;
  for (const PosePoint& member : members) angles.push_back(circle.match(member, symmetries).along);
  // A triangular window: of a flat top the middle.
  const auto density = [&](double angle) {
    double sum = 0;
    for (const double other : angles) {
      const double off = std::abs(std::remainder(other - angle, 2 * pi));
      sum += std::max(0.0, 1 - off / PoseTolerance{}.rotation);
    }
    return sum;
  };
  const double middle = density(0);
  double densest = 0, most = middle + kClearlyMore * std::sqrt(middle + 1);
  for (double angle = -axis.extent; angle <= axis.extent; angle += kSpacing) {
    const double found = density(angle);
    if (found <= most) continue;
    most = found;
    densest = angle;
  }
  axis.extent = std::min(pi, axis.extent + std::abs(densest));
  return {family.at(densest), axis};
}

std::optional<PoseFamily> fit_free_axis(const std::vector<PosePoint>& poses, const PosePoint& seed,
                                        const PoseFamily::Symmetries& symmetries) {
  std::optional<PoseFamily> family = best_line(poses, seed, symmetries);
  if (!family) return std::nullopt;
  for (int i = 0; i < kRefits; ++i) {
    const auto members = matches_within(*family, poses, symmetries);
    if (members.empty()) return std::nullopt;
    family = refitted(*family, members);
  }
  std::vector<double> angles;
  for (const auto& member : matches_within(*family, poses, symmetries)) {
    angles.push_back(member.along);
  }
  const Arc arc = fullest_arc(std::move(angles));
  if (arc.extent < kMinExtent) return std::nullopt;
  FreeAxis axis = *family->axis();
  axis.extent = arc.extent;
  return PoseFamily(family->at(arc.middle), axis);
}

}  // namespace palpate::localization
