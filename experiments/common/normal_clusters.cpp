// SPDX-License-Identifier: Apache-2.0
#include "normal_clusters.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/core/error.hpp"
#include "palpate/core/option_check.hpp"
#include "palpate/core/se3.hpp"
#include "tactile/normals/noise_meter.hpp"

namespace palpate::tactile {
namespace {

constexpr std::size_t kSeeds = 500;  // directions tried for a face's
constexpr int kShifts = 10;
constexpr double kUnit = 1e-3;  // that a unit normal's length may be off

void require_finite(const Eigen::Vector3d& v, std::size_t index, const char* what) {
  if (!v.allFinite()) {
    throw BadInput(
        fmt::format("{} {} is ({}, {}, {}), not finite", what, index, v.x(), v.y(), v.z()));
  }
}

void require_sound(std::span<const NormalAt> contacts) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    require_finite(contacts[i].p, i, "point");
    require_finite(contacts[i].n, i, "normal");
    const double length = contacts[i].n.norm();
    if (std::abs(length - 1) < kUnit) continue;
    throw BadInput(fmt::format("normal {} has the length {}, not 1", i, length));
  }
}

/// All contacts that chains of neighbours join to `seed`, which they leave in `rest`.
std::vector<std::size_t> chain_from(std::size_t seed, std::span<const NormalAt> contacts,
                                    const ClusterOptions& options, std::vector<std::size_t>& rest) {
  const double min_cosine = std::cos(options.angle);
  std::vector<std::size_t> chain = {seed};
  for (std::size_t next = 0; next < chain.size(); ++next) {
    const NormalAt& from = contacts[chain[next]];
    const auto joins = [&](std::size_t i) {
      return (contacts[i].p - from.p).norm() <= options.distance &&
             contacts[i].n.dot(from.n) >= min_cosine;
    };
    const auto joined =
        std::stable_partition(rest.begin(), rest.end(), [&](std::size_t i) { return !joins(i); });
    chain.insert(chain.end(), joined, rest.end());
    rest.erase(joined, rest.end());
  }
  return chain;
}

NormalCluster summed(const std::vector<std::size_t>& chain, std::span<const NormalAt> contacts) {
  NormalCluster cluster{.p = Eigen::Vector3d::Zero(), .n = Eigen::Vector3d::Zero()};
  cluster.size = chain.size();
  for (std::size_t i : chain) {
    cluster.p += contacts[i].p / static_cast<double>(chain.size());
    cluster.n += contacts[i].n;
  }
  cluster.n.normalize();
  return cluster;
}

/// The contacts whose normals are within an angle of one.
struct Around {
  Eigen::Vector3d n;         ///< mean normal, unit
  double share = 0;          ///< of all contacts
  double spread = 0;         ///< of the points in the plane of the mean, over their noise, least
  double concentration = 0;  ///< share of those within twice the angle
};

/// How far points of a scatter spread in the plane across n, over their noise (covariances), in the
/// direction where that is least.
double spread_across(const Eigen::Vector3d& n, const Eigen::Matrix3d& scatter,
                     const Eigen::Matrix3d& noise) {
  const Eigen::Matrix<double, 3, 2> B = frame_with_z(n).leftCols<2>();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      B.transpose() * scatter * B, B.transpose() * noise * B, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

Around around(const Eigen::Vector3d& n, std::span<const NormalAt> contacts, double radius,
              const Eigen::Matrix3d& noise) {
  const double min_cosine = std::cos(radius), wide_cosine = std::cos(2 * radius);
  Eigen::Vector3d normals = Eigen::Vector3d::Zero(), points = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0, wide = 0;
  for (const NormalAt& contact : contacts) {
    const double cosine = contact.n.dot(n);
    wide += cosine >= wide_cosine;
    if (cosine < min_cosine) continue;
    const Eigen::Vector3d p = contact.p - contacts.front().p;
    normals += contact.n;
    points += p;
    squares += p * p.transpose();
    ++count;
  }
  const Eigen::Matrix3d scatter = (squares - points * points.transpose() / count) / count;
  return {normals.normalized(), count / static_cast<double>(contacts.size()),
          spread_across(normals.normalized(), scatter, noise), count / wide};
}

/// Covariance of the points' noise, from their second differences, without jumps.
Eigen::Matrix3d noise_of_points(std::span<const NormalAt> contacts) {
  constexpr double kUsual = 1e-3, kLeast = 1e-9;  // m
  constexpr double kJump = 72;  // squared second difference over the variance; 18 on average
  NoiseMeter meter(3, kUsual, kLeast, static_cast<double>(contacts.size()));
  for (const NormalAt& contact : contacts) meter.add(contact.p);
  const double variance = meter.sigma() * meter.sigma();
  Eigen::Matrix3d sum = variance * Eigen::Matrix3d::Identity();
  double count = 1;
  for (std::size_t i = 2; i < contacts.size(); ++i) {
    const Eigen::Vector3d d = contacts[i].p - 2 * contacts[i - 1].p + contacts[i - 2].p;
    if (d.squaredNorm() > kJump * variance) continue;
    sum += d * d.transpose() / 6;
    ++count;
  }
  return sum / count;
}

/// The densest direction near n, by mean shift.
Around densest_near(const Eigen::Vector3d& n, std::span<const NormalAt> contacts, double radius,
                    const Eigen::Matrix3d& noise) {
  Around best = around(n, contacts, radius, noise);
  for (int shift = 0; shift < kShifts; ++shift) {
    const Around next = around(best.n, contacts, radius, noise);
    if (next.share <= best.share) break;
    best = next;
  }
  return best;
}

/// The direction again within half the radius, where normals from the way round an edge, all on
/// one side, count for less.
Eigen::Vector3d refined(const Eigen::Vector3d& n, std::span<const NormalAt> contacts,
                        double radius) {
  Eigen::Vector3d mean = n;
  for (int shift = 0; shift < kShifts; ++shift) {
    mean = around(mean, contacts, radius / 2, Eigen::Matrix3d::Identity()).n;
  }
  return mean;
}

/// The directions that contacts have in common and that are faces, densest first.
std::vector<Face> face_candidates(std::span<const NormalAt> contacts, const FaceOptions& options) {
  const Eigen::Matrix3d noise = noise_of_points(contacts);
  const std::size_t stride = std::max<std::size_t>(1, contacts.size() / kSeeds);
  std::vector<Face> candidates;
  for (std::size_t i = 0; i < contacts.size(); i += stride) {
    const Around mode = densest_near(contacts[i].n, contacts, options.radius, noise);
    if (mode.share < options.min_share || mode.spread < options.min_spread ||
        mode.concentration < options.min_concentration) {
      continue;
    }
    candidates.push_back({mode.n, mode.share});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Face& a, const Face& b) { return a.share > b.share; });
  return candidates;
}

}  // namespace

std::vector<NormalCluster> cluster_normals(std::span<const NormalAt> contacts,
                                           const ClusterOptions& options) {
  checked(options);
  require_sound(contacts);
  std::vector<std::size_t> rest(contacts.size());
  std::iota(rest.begin(), rest.end(), std::size_t{0});
  std::vector<NormalCluster> clusters;
  while (!rest.empty()) {
    const std::size_t seed = rest.front();
    rest.erase(rest.begin());
    const auto chain = chain_from(seed, contacts, options, rest);
    if (static_cast<int>(chain.size()) >= options.min) clusters.push_back(summed(chain, contacts));
  }
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size > b.size; });
  return clusters;
}

std::vector<Face> find_faces(std::span<const NormalAt> contacts, const FaceOptions& options) {
  checked(options);
  require_sound(contacts);
  std::vector<Face> faces;
  if (contacts.empty()) return faces;
  const double near = std::cos(options.apart);
  for (const Face& candidate : face_candidates(contacts, options)) {
    const bool apart = std::all_of(faces.begin(), faces.end(), [&](const Face& face) {
      return face.n.dot(candidate.n) < near;
    });
    if (apart) faces.push_back({refined(candidate.n, contacts, options.radius), candidate.share});
  }
  return faces;
}

}  // namespace palpate::tactile
