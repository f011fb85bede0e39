// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/skills/place/place_target.hpp"

namespace palpate::skills {
namespace {

constexpr double kMinRoom = 0.0005;                          // m to every side
constexpr double kMinSide = 0.001;                           // m of a wall worth building
constexpr double kMinTurn = 12 * std::numbers::pi / 180;     // rad between two walls
constexpr double kWidestTurn = std::numbers::pi / 2 + 1e-6;  // rad

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Places over the table of all that is lower than `height`: vertices, and where edges cross it.
std::vector<Eigen::Vector2d> low_points(const geometry::TriangleMesh& mesh,
                                        const Eigen::Isometry3d& T_table_object, double height) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](int i) -> Eigen::Vector3d {
        return T_table_object * mesh.vertices[static_cast<std::size_t>(triangle[(k + i) % 3])];
      };
      const Eigen::Vector3d a = at(0), b = at(1);
      if (a.z() < height) points.push_back(a.head<2>());
      if ((a.z() < height) == (b.z() < height)) continue;
      points.push_back((a + (height - a.z()) / (b.z() - a.z()) * (b - a)).head<2>());
    }
  }
  return points;
}

/// Corners of the convex outline, anticlockwise (Andrew 1979).
std::vector<Eigen::Vector2d> outline(std::vector<Eigen::Vector2d> points) {
  const auto before = [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), before);
  std::vector<Eigen::Vector2d> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t first = hull.size();
    for (const auto& p : points) {
      while (hull.size() >= first + 2 &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

double angle_between(double a, double b) {
  return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

/// Directions (rad) of the walls' outward normals: those of the longest sides, no two nearly alike,
/// and the axes where that would leave the slot open.
std::vector<double> wall_directions(const std::vector<Eigen::Vector2d>& hull) {
  std::vector<std::pair<double, double>> sides;  // length, direction of the outward normal
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d side = hull[(i + 1) % hull.size()] - hull[i];
    sides.emplace_back(side.norm(), std::atan2(-side.x(), side.y()));
  }
  std::sort(sides.begin(), sides.end(), std::greater<>());
  std::vector<double> chosen;
  const auto clear = [&](double direction, double least) {
    return std::all_of(chosen.begin(), chosen.end(),
                       [&](double other) { return angle_between(direction, other) > least; });
  };
  for (const auto& [length, direction] : sides) {
    if (clear(direction, kMinTurn)) chosen.push_back(direction);
  }
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double direction = quarter * std::numbers::pi / 2;
    if (clear(direction, kWidestTurn / 2)) chosen.push_back(direction);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

struct Side {
  Eigen::Vector2d normal;
  double distance = 0;  // of the wall's inner face from the origin along the normal, m
};

Eigen::Vector2d meeting(const Side& a, const Side& b) {
  Eigen::Matrix2d normals;
  normals << a.normal.transpose(), b.normal.transpose();
  return normals.inverse() * Eigen::Vector2d(a.distance, b.distance);
}

std::vector<Side> sides_of(const std::vector<Eigen::Vector2d>& hull, double tolerance) {
  std::vector<Side> sides;
  for (const double direction : wall_directions(hull)) {
    Side side{{std::cos(direction), std::sin(direction)}, -1.0};
    for (const auto& p : hull) side.distance = std::max(side.distance, side.normal.dot(p));
    side.distance += tolerance;
    sides.push_back(side);
  }
  return sides;
}

}  // namespace

planning::Fixture make_fixture(const geometry::KnownObject& object, const FixtureOptions& options) {
  if (options.stable_pose >= static_cast<int>(object.stable_poses.size())) {
    throw BadInput(fmt::format("fixture.stable_pose = {}: {} has the stable poses 0..{}",
                               options.stable_pose, object.name, object.stable_poses.size() - 1));
  }
  if (options.tolerance < kMinRoom) {
    throw BadInput(
        fmt::format("the fixture is too small: {:.2f} mm of room to a side of {}, less "
                    "than {:.2f}",
                    1e3 * options.tolerance, object.name, 1e3 * kMinRoom));
  }
  const auto stable_pose = static_cast<std::size_t>(options.stable_pose);
  const Eigen::Isometry3d seated = resting_pose(object, stable_pose, {0, 0}, options.yaw);
  const auto sides =
      sides_of(outline(low_points(object.mesh, seated, options.height)), options.tolerance);
  planning::Fixture fixture;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Side& side = sides[i];
    const Eigen::Vector2d from = meeting(sides[(i + sides.size() - 1) % sides.size()], side);
    const Eigen::Vector2d to = meeting(side, sides[(i + 1) % sides.size()]);
    if ((to - from).norm() < kMinSide) continue;
    const Eigen::Vector2d middle = 0.5 * (from + to) + 0.5 * options.wall * side.normal;
    planning::FixtureBox box;
    box.T_world_box.translation() << options.x + middle.x(), options.y + middle.y(),
        0.5 * options.height;
    box.T_world_box.linear() =
        Eigen::AngleAxisd(std::atan2(side.normal.y(), side.normal.x()), Eigen::Vector3d::UnitZ())
            .toRotationMatrix();
    box.half_extents << 0.5 * options.wall, 0.5 * (to - from).norm() + 0.5 * options.wall,
        0.5 * options.height;
    fixture.push_back(box);
  }
  return fixture;
}

}  // namespace palpate::skills
