// SPDX-License-Identifier: Apache-2.0
#include "palpate/touch/normal_clusters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::touch {
namespace {

constexpr std::size_t kSeeds = 500;  // directions tried for a face's
constexpr int kShifts = 10;

void require_finite(const Eigen::Vector3d& v, std::size_t index, const char* what) {
  if (!v.allFinite()) {
    throw BadInput(
        fmt::format("{} {} is ({}, {}, {}), not finite", what, index, v.x(), v.y(), v.z()));
  }
}

/// All contacts that chains of neighbours join to `seed`, which they leave in `rest`.
std::vector<std::size_t> chain_from(std::size_t seed, std::span<const NormalAt> contacts,
                                    const ClusterOptions& options, std::vector<std::size_t>& rest) {
  const double least_cosine = std::cos(options.angle);
  std::vector<std::size_t> chain = {seed};
  for (std::size_t next = 0; next < chain.size(); ++next) {
    const NormalAt& from = contacts[chain[next]];
    const auto joins = [&](std::size_t i) {
      return (contacts[i].p - from.p).norm() <= options.distance &&
             contacts[i].n.dot(from.n) >= least_cosine;
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

/// Mean of the normals around n and how many they are.
std::pair<Eigen::Vector3d, std::size_t> around(const Eigen::Vector3d& n,
                                               std::span<const Eigen::Vector3d> normals,
                                               double radius) {
  const double least_cosine = std::cos(radius);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (const Eigen::Vector3d& other : normals) {
    if (other.dot(n) < least_cosine) continue;
    sum += other;
    ++count;
  }
  return {sum.normalized(), count};
}

/// The densest direction among the normals that are apart from all faces.
Face densest(std::span<const Eigen::Vector3d> normals, const std::vector<Face>& faces,
             const FaceOptions& options) {
  const double near = std::cos(options.apart);
  const auto apart = [&](const Eigen::Vector3d& n) {
    return std::all_of(faces.begin(), faces.end(),
                       [&](const Face& face) { return face.n.dot(n) < near; });
  };
  Face best;
  const std::size_t stride = std::max<std::size_t>(1, normals.size() / kSeeds);
  const auto all = static_cast<double>(normals.size());
  for (std::size_t i = 0; i < normals.size(); i += stride) {
    if (!apart(normals[i])) continue;
    const double share =
        static_cast<double>(around(normals[i], normals, options.radius).second) / all;
    if (share > best.share) best = {normals[i], share};
  }
  for (int shift = 0; best.share > 0 && shift < kShifts; ++shift) {
    const auto [mean, count] = around(best.n, normals, options.radius);
    if (!apart(mean)) break;
    best = {mean, static_cast<double>(count) / all};
  }
  return best;
}

}  // namespace

std::vector<NormalCluster> cluster_normals(std::span<const NormalAt> contacts,
                                           const ClusterOptions& options) {
  std::vector<std::size_t> rest;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    require_finite(contacts[i].p, i, "point");
    require_finite(contacts[i].n, i, "normal");
    rest.push_back(i);
  }
  std::vector<NormalCluster> clusters;
  while (!rest.empty()) {
    const std::size_t seed = rest.front();
    rest.erase(rest.begin());
    const auto chain = chain_from(seed, contacts, options, rest);
    if (static_cast<int>(chain.size()) >= options.least)
      clusters.push_back(summed(chain, contacts));
  }
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.size > b.size; });
  return clusters;
}

std::vector<Face> find_faces(std::span<const Eigen::Vector3d> normals, const FaceOptions& options) {
  for (std::size_t i = 0; i < normals.size(); ++i) require_finite(normals[i], i, "normal");
  std::vector<Face> faces;
  while (true) {
    const Face face = densest(normals, faces, options);
    if (face.share == 0 || face.share < options.least_share) return faces;
    faces.push_back(face);
  }
}

}  // namespace palpate::touch
