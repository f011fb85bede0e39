// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/stable_poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "geometry/objects/rolling.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

using Facets = std::vector<RestingFacet>;

void check(const StablePoseOptions& options) {
  if (options.barrier < 0 || options.merge_angle_deg < 0 || options.max_stable_poses < 1 ||
      options.min_probability < 0 || options.min_probability >= 1) {
    throw BadInput(
        fmt::format("stable pose options out of range: barrier {} m, merge angle {} deg, least "
                    "probability {}, at most {} stable poses",
                    options.barrier, options.merge_angle_deg, options.min_probability,
                    options.max_stable_poses));
  }
}

void max_probable_first(Facets& facets) {
  std::ranges::stable_sort(facets, std::greater{}, &RestingFacet::probability);
}

/// Joins facets with up vectors within an angle into the most probable of them.
Facets merge_close(Facets facets, double angle) {
  max_probable_first(facets);
  Facets merged;
  for (const RestingFacet& facet : facets) {
    const auto close = std::ranges::find_if(merged, [&](const RestingFacet& other) {
      return other.normal.dot(facet.normal) > std::cos(angle);
    });
    if (close == merged.end()) {
      merged.push_back(facet);
    } else {
      close->probability += facet.probability;
    }
  }
  return merged;
}

double probability(const Facets& facets) {
  double sum = 0;
  for (const RestingFacet& facet : facets) sum += facet.probability;
  return sum;
}

/// `count` members of a family, the most probable and then always the farthest from those chosen;
/// each takes the share of the members nearest to it.
Facets spread(const Facets& family, int count) {
  if (static_cast<int>(family.size()) <= count) return family;
  Facets chosen = {family.front()};
  const auto nearest = [&](const RestingFacet& facet) {
    return std::ranges::max_element(
        chosen, {}, [&](const RestingFacet& other) { return other.normal.dot(facet.normal); });
  };
  while (static_cast<int>(chosen.size()) < count) {
    chosen.push_back(*std::ranges::min_element(family, {}, [&](const RestingFacet& facet) {
      return nearest(facet)->normal.dot(facet.normal);
    }));
  }
  for (RestingFacet& facet : chosen) facet.probability = 0;
  for (const RestingFacet& facet : family) nearest(facet)->probability += facet.probability;
  return chosen;
}

/// Families worth keeping, most probable first, each with its members most probable first.
std::vector<Facets> families_of(const Facets& facets, const StablePoseOptions& options) {
  std::map<int, Facets> by_family;
  for (const RestingFacet& facet : facets) by_family[facet.family].push_back(facet);
  std::vector<Facets> families;
  for (auto& [id, members] : by_family) {
    if (probability(members) >= options.min_probability) families.push_back(std::move(members));
  }
  std::ranges::stable_sort(families, std::greater{}, probability);
  families.resize(std::min(families.size(), static_cast<std::size_t>(options.max_stable_poses)));
  return families;
}

Facets choose(const Facets& facets, const StablePoseOptions& options) {
  const std::vector<Facets> families = families_of(facets, options);
  double total = 0;
  for (const Facets& family : families) total += probability(family);
  const int spare = options.max_stable_poses - static_cast<int>(families.size());
  Facets chosen;
  for (const Facets& family : families) {
    const int count = 1 + static_cast<int>(spare * probability(family) / total);
    const Facets members = spread(family, count);
    chosen.insert(chosen.end(), members.begin(), members.end());
  }
  for (RestingFacet& facet : chosen) facet.probability /= total;
  max_probable_first(chosen);
  return chosen;
}

/// R_table_object that lays a facet with that outward normal on the table.
Eigen::Matrix3d lay_down(const Eigen::Vector3d& normal) {
  constexpr double kNearlyUpright = 0.9;
  const Eigen::Vector3d up = -normal;
  const Eigen::Vector3d ahead =
      std::abs(up.x()) < kNearlyUpright ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix3d R;
  R.row(0) = (ahead - ahead.dot(up) * up).normalized();
  R.row(2) = up;
  R.row(1) = up.cross(Eigen::Vector3d(R.row(0)));
  return R;
}

}  // namespace

std::vector<StablePose> stable_poses(const TriangleMesh& mesh, const Eigen::Vector3d& centroid,
                                     const StablePoseOptions& options) {
  check(options);
  const Facets resting = resting_facets(convex_hull(mesh.vertices), centroid, options.barrier);
  const double angle = options.merge_angle_deg * std::numbers::pi / 180;
  std::vector<StablePose> stable_poses;
  for (const RestingFacet& facet : choose(merge_close(resting, angle), options)) {
    stable_poses.push_back({lay_down(facet.normal), facet.height, facet.probability});
  }
  return stable_poses;
}

}  // namespace palpate::geometry
