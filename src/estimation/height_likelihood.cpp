// SPDX-License-Identifier: Apache-2.0
#include "estimation/height_likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/estimation/height_probe.hpp"
#include "palpate/geometry/mesh/sampling.hpp"

namespace palpate::estimation {
namespace {

constexpr double kCell = 0.004;               // m
constexpr std::size_t kSurfacePoints = 4000;  // of an object
constexpr int kPlaces = 64;                   // and directions
constexpr double kByAnything = 0.02;          // probability that something else stopped the hand
constexpr double kNothing = -std::numeric_limits<double>::infinity();

/// Height of an object above each cell of the table.
struct HeightMap {
  Eigen::Vector2d corner;
  Eigen::MatrixXd heights;  // m; kNothing where there is none of it
  double top = 0;

  [[nodiscard]] Eigen::Vector2i cell(const Eigen::Vector2d& p) const {
    return ((p - corner) / kCell).array().floor().cast<int>();
  }
};

HeightMap height_map(const std::vector<geometry::SurfaceSample>& surface,
                     const Eigen::Isometry3d& T_table_object) {
  Eigen::Matrix3Xd points(3, surface.size());
  for (std::size_t i = 0; i < surface.size(); ++i) {
    points.col(static_cast<Eigen::Index>(i)) = T_table_object.linear() * surface[i].point;
  }
  points.colwise() += T_table_object.translation();
  HeightMap map;
  map.corner = points.topRows<2>().rowwise().minCoeff();
  map.top = points.row(2).maxCoeff();
  const Eigen::Vector2i size =
      map.cell(points.topRows<2>().rowwise().maxCoeff()) + Eigen::Vector2i::Ones();
  map.heights = Eigen::MatrixXd::Constant(size.x(), size.y(), kNothing);
  for (const auto& p : points.colwise()) {
    const Eigen::Vector2i cell = map.cell(p.head<2>());
    double& height = map.heights(cell.x(), cell.y());
    height = std::max(height, p.z());
  }
  return map;
}

Eigen::Isometry3d on_table(const geometry::StablePose& stable_pose) {
  Eigen::Isometry3d T_table_object = Eigen::Isometry3d::Identity();
  T_table_object.linear() = stable_pose.R_table_object;
  T_table_object.translation().z() = stable_pose.height;
  return T_table_object;
}

/// Part of a hand, relative to the hand's lowest point.
struct Part {
  Eigen::Vector3d center;
  double radius;
};

std::vector<Part> parts_of(const hand::Description& model, const hand::HandReading& above) {
  const auto T_mount_link = hand::forward_kinematics(model, above.joints);
  const Eigen::Isometry3d T_world_mount = above.mount.pose();
  const double lowest = lowest_of_hand(model, above);
  std::vector<Part> parts;
  for (const auto& sphere : model.spheres) {
    Eigen::Vector3d center =
        T_world_mount * T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center;
    center.z() -= lowest;
    parts.push_back({center, sphere.radius});
  }
  return parts;
}

/// Height of the hand's lowest point in which a part of it is stopped; `least` if that is higher.
/// @param center  of the part on the table, in the map's frame
double stopped_by(const HeightMap& map, const Part& part, const Eigen::Vector2d& center,
                  double least) {
  if (map.top + part.radius - part.center.z() <= least) return least;
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(part.radius);
  const Eigen::Vector2i from = map.cell(center - reach).cwiseMax(0);
  const Eigen::Vector2i to =
      map.cell(center + reach)
          .cwiseMin(Eigen::Vector2i(map.heights.rows() - 1, map.heights.cols() - 1));
  for (int y = from.y(); y <= to.y(); ++y) {
    for (int x = from.x(); x <= to.x(); ++x) {
      const Eigen::Vector2d middle = map.corner + kCell * Eigen::Vector2d(x + 0.5, y + 0.5);
      const double down = part.radius * part.radius - (middle - center).squaredNorm();
      if (down < 0) continue;
      least = std::max(least, map.heights(x, y) + std::sqrt(down) - part.center.z());
    }
  }
  return least;
}

/// The i-th of points spread evenly over the unit cube (additive recurrence, Roberts 2018).
Eigen::Vector3d spread(int i) {
  constexpr double kPlastic = 1.22074408460575947536;  // the root of x^4 = x + 1
  const Eigen::Vector3d step(1 / kPlastic, 1 / (kPlastic * kPlastic),
                             1 / (kPlastic * kPlastic * kPlastic));
  const Eigen::Vector3d p = Eigen::Vector3d::Constant(0.5) + (i + 1) * step;
  return p.array() - p.array().floor();
}

std::vector<double> stopping_heights(const HeightMap& map, const std::vector<Part>& parts,
                                     const PlaceOnTable& place) {
  std::vector<double> heights;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector3d at = spread(i);
    const Eigen::Vector2d object =
        place.middle + place.half_width * (2 * at.head<2>().array() - 1).matrix();
    const Eigen::Rotation2Dd R_object_table(-2 * std::numbers::pi * at.z());
    double height = 0;
    for (const Part& part : parts) {
      height = stopped_by(map, part, R_object_table * (part.center.head<2>() - object), height);
    }
    heights.push_back(height);
  }
  return heights;
}

std::vector<geometry::SurfaceSample> surface_of(const geometry::KnownObject& object) {
  return geometry::sample_surface(object.mesh, kSurfacePoints,
                                  RandomStream(0, "felt height"));  // the text seeds the stream
}

double likelihood(const std::vector<double>& heights, double stopped, double sigma) {
  double sum = 0;
  for (const double height : heights) {
    const double miss = (height - stopped) / sigma;
    sum += std::exp(-0.5 * miss * miss);
  }
  return kByAnything + (1 - kByAnything) * sum / static_cast<double>(heights.size());
}

}  // namespace

std::vector<double> stopping_heights(const geometry::KnownObject& object,
                                     const geometry::StablePose& stable_pose,
                                     const hand::Description& model, const hand::HandReading& above,
                                     const PlaceOnTable& place) {
  return stopping_heights(height_map(surface_of(object), on_table(stable_pose)),
                          parts_of(model, above), place);
}

double stopping_height(const geometry::KnownObject& object, const Eigen::Isometry3d& T_world_object,
                       const hand::Description& model, const hand::HandReading& above) {
  const HeightMap map = height_map(surface_of(object), T_world_object);
  double height = 0;
  for (const Part& part : parts_of(model, above)) {
    height = stopped_by(map, part, part.center.head<2>(), height);
  }
  return height;
}

std::vector<double> probed_height_likelihoods(const geometry::KnownObject& object,
                                              const hand::Description& model,
                                              const hand::HandReading& stopped,
                                              const PlaceOnTable& place, double sigma) {
  const auto surface = surface_of(object);
  const auto parts = parts_of(model, stopped);
  const double height = lowest_of_hand(model, stopped);
  std::vector<double> likelihoods;
  for (const auto& stable_pose : object.stable_poses) {
    const auto heights = stopping_heights(height_map(surface, on_table(stable_pose)), parts, place);
    likelihoods.push_back(likelihood(heights, height, sigma));
  }
  return likelihoods;
}

}  // namespace palpate::estimation
