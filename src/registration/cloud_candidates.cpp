// SPDX-License-Identifier: Apache-2.0
#include "registration/cloud_candidates.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <numeric>

#include "palpate/core/parallel.hpp"
#include "registration/cloud_refinement.hpp"
#include "registration/neighbour_rounds.hpp"

namespace palpate::registration {
namespace {

using geometry::PointCloud;

constexpr double kReach = 3;  // bounds, within which a pose that is not refined yet may fit

struct PrincipalAxes {
  /// The mean, and the centre of the box along the axes: a cup turned over stands where it stood
  /// about the latter.
  std::array<Eigen::Vector3d, 2> centers;
  Eigen::Matrix3d directions;  // columns
};

PrincipalAxes principal_axes(const PointCloud& cloud) {
  PrincipalAxes axes;
  const auto count = static_cast<double>(cloud.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : cloud.points) mean += p / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& p : cloud.points) covariance += (p - mean) * (p - mean).transpose() / count;
  axes.directions = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  Eigen::AlignedBox3d box;
  for (const auto& p : cloud.points) box.extend(axes.directions.transpose() * p);
  axes.centers = {mean, axes.directions * box.center()};
  return axes;
}

/// Every so many points that about `enough` are left.
PointCloud some_points(const PointCloud& cloud, std::size_t enough = 1000) {
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / enough);
  std::vector<int> kept;
  for (std::size_t i = 0; i < cloud.size(); i += stride) kept.push_back(static_cast<int>(i));
  return geometry::subset(cloud, kept);
}

/// The two clouds held against one another, each by some of its points.
class Fit {
 public:
  Fit(const PointCloud& source, const PointCloud& target, double bound, const CloudOptions& options)
      : bound_(bound),
        some_source_(some_points(source)),
        some_target_(some_points(target)),
        to_target_(some_source_, target, options.registration.primitive,
                   options.registration.turns(), options.threads),
        to_source_(some_target_, source, options.registration.primitive, {}, options.threads) {}

  Eigen::Isometry3d refined(const Eigen::Isometry3d& T) {
    constexpr int kRounds = 15;
    const Eigen::Isometry3d near = settled(to_target_, T, kReach * bound_, kRounds).value_or(T);
    return settled(to_target_, near, bound_, kRounds).value_or(near);
  }

  /// The few of many poses at which the clouds fit best as they are.
  std::vector<Eigen::Isometry3d> nearest(const std::vector<Eigen::Isometry3d>& poses) {
    constexpr std::size_t kKept = 16;
    if (poses.size() <= kKept) return poses;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      order.emplace_back(to_target_.share_within(poses[i], kReach * bound_), i);
    }
    std::ranges::stable_sort(order, std::greater<>(), &std::pair<double, std::size_t>::first);
    std::vector<Eigen::Isometry3d> kept;
    for (std::size_t k = 0; k < kKept; ++k) kept.push_back(poses[order[k].second]);
    return kept;
  }

  /// Of the points of both clouds.
  std::vector<double> costs(const Eigen::Isometry3d& T) {
    std::vector<double> costs = to_target_.truncated_costs(T, bound_, bound_ / 2);
    const auto others = to_source_.truncated_costs(T.inverse(), bound_, bound_ / 2);
    costs.insert(costs.end(), others.begin(), others.end());
    return costs;
  }

  std::vector<double> worst() const {
    return std::vector<double>(some_source_.size() + some_target_.size(), 1);
  }

 private:
  double bound_;
  PointCloud some_source_, some_target_;
  NeighbourRounds to_target_, to_source_;
};

double sum_of(const std::vector<double>& costs) {
  return std::accumulate(costs.begin(), costs.end(), 0.0);
}

}  // namespace

std::vector<Eigen::Isometry3d> turned_about_axes(const PointCloud& source,
                                                 const Eigen::Isometry3d& T, int steps) {
  const PrincipalAxes axes = principal_axes(source);
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < 3; ++k) {
    for (int step = 1; step < steps; ++step) {
      const Eigen::AngleAxisd turn(2 * std::numbers::pi * step / steps, axes.directions.col(k));
      for (const auto& center : axes.centers) {
        poses.push_back(T * Eigen::Translation3d(center) * turn * Eigen::Translation3d(-center));
      }
    }
  }
  return poses;
}

std::vector<Eigen::Isometry3d> with_axes_aligned(const PointCloud& source,
                                                 const PointCloud& target) {
  const PrincipalAxes from = principal_axes(source), to = principal_axes(target);
  std::vector<Eigen::Isometry3d> poses;
  for (const double x : {1, -1}) {
    for (const double y : {1, -1}) {
      Eigen::Matrix3d turned = to.directions;
      turned.col(0) *= x;
      turned.col(1) *= y;
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.linear() = turned * from.directions.transpose();
      if (T.linear().determinant() < 0) {
        turned.col(2) *= -1;
        T.linear() = turned * from.directions.transpose();
      }
      for (std::size_t k = 0; k < from.centers.size(); ++k) {
        T.translation() = to.centers[k] - T.linear() * from.centers[k];
        poses.push_back(T);
      }
    }
  }
  return poses;
}

std::vector<Eigen::Isometry3d> reflected(const PointCloud& source, const Eigen::Isometry3d& T) {
  const PrincipalAxes axes = principal_axes(source);
  std::vector<Eigen::Isometry3d> reflections;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d n = axes.directions.col(k);
    Eigen::Isometry3d reflection = Eigen::Isometry3d::Identity();
    reflection.linear() -= 2 * n * n.transpose();
    for (const auto& center : axes.centers) {
      reflection.translation() = 2 * n.dot(center) * n;
      reflections.push_back(T * reflection);
    }
  }
  return reflections;
}

std::vector<Eigen::Isometry3d> unmirrored(const PointCloud& source,
                                          const Eigen::Isometry3d& T_mirrored) {
  const PrincipalAxes axes = principal_axes(source);
  const Eigen::DiagonalMatrix<double, 3> mirror(-1, 1, 1);
  std::vector<Eigen::Isometry3d> poses;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d n = axes.directions.col(k);
    const Eigen::Matrix3d reflect = Eigen::Matrix3d::Identity() - 2 * n * n.transpose();
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() = mirror * reflect;
    for (const auto& center : axes.centers) {
      turn.translation() = mirror * (center - reflect * center);
      poses.push_back(T_mirrored * turn);
    }
  }
  return poses;
}

std::optional<std::vector<Eigen::Isometry3d>> promising(
    const PointCloud& source, const PointCloud& target, const Eigen::Isometry3d& T,
    const std::vector<Eigen::Isometry3d>& others, double noise_bound, const CloudOptions& options) {
  constexpr std::size_t kEnough = 300;  // to distinguish poses that are far from fitting
  constexpr double kSurplus = 0.02, kMostLies = 0.95;
  const PointCloud some = some_points(source, kEnough);
  const NeighbourRounds to_target(some, target, options.registration.primitive,
                                  options.registration.turns(), options.threads);
  const auto shares = [&](const Eigen::Isometry3d& at) {
    return std::pair(to_target.share_within(at, noise_bound),
                     to_target.share_within(at, kReach * noise_bound));
  };
  const auto [near, around] = shares(T);
  if (around < kMostLies) return std::nullopt;
  std::vector<Eigen::Isometry3d> kept;
  if (std::min(near, around) > 1 - kSurplus) return kept;
  std::vector<std::pair<double, double>> of_others(others.size());
  parallel_for(others.size(), options.threads,
               [&](std::size_t i) { of_others[i] = shares(others[i]); });
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto [other_near, other_around] = of_others[i];
    if (other_near > near + kSurplus || other_around > around + kSurplus) kept.push_back(others[i]);
  }
  return kept;
}

std::optional<BetterFit> better_fitting(const PointCloud& source, const PointCloud& target,
                                        const std::optional<Eigen::Isometry3d>& T,
                                        const std::vector<Eigen::Isometry3d>& others,
                                        double noise_bound, const CloudOptions& options) {
  constexpr double kDeviations = 1;  // between poses that fit alike the first stays
  Fit fit(source, target, noise_bound, options);
  const std::vector<double> first = T ? fit.costs(fit.refined(*T)) : fit.worst();
  double least = sum_of(first);
  std::optional<BetterFit> best;
  for (const auto& other : fit.nearest(others)) {
    const Eigen::Isometry3d refined = fit.refined(other);
    const std::vector<double> costs = fit.costs(refined);
    const double deviations = standard_errors(first, costs, 1);
    if (sum_of(costs) >= least || deviations < kDeviations) continue;
    least = sum_of(costs);
    best = {refined, deviations};
  }
  return best;
}

}  // namespace palpate::registration
