// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/tactile/contacts/finger_sample.hpp"

/// A fingertip that slides over surfaces whose normals are known exactly.
namespace palpate::tactile {

enum class Surface { flat, edge, smooth, corner };
inline constexpr std::array<Surface, 4> kSurfaces = {Surface::flat, Surface::edge, Surface::smooth,
                                                     Surface::corner};
inline constexpr std::array<std::string_view, 4> kSurfaceNames = {"flat", "edge", "smooth",
                                                                  "corner"};

struct SlidingOptions {
  double seconds = 10;
  double period = 0.01;     // s
  double speed = 0.02;      // m/s
  double normal_force = 2;  // N, swelling and fading by 30 % at 0.7 Hz
  double friction = 0.5;
  double force_noise = 0.05;   // N, per axis
  double point_noise = 1e-4;   // m, per axis
  double tip_noise = 1e-3;     // m, per axis, of the contact's place on the tip
  double tip_radius = 0.007;   // m
  double edge_radius = 0.001;  // m, of edges and corner
  double ball_radius = 0.05;   // m, of the smooth surface
};

/// Points and outward normals of the surface along the finger's path.
struct SlidingPath {
  std::vector<Eigen::Vector3d> p, n;
};

/// Walk in the plane at constant speed, whose heading turns by about 1 rad/s (rms).
inline std::vector<Eigen::Vector2d> planar_walk(const SlidingOptions& options,
                                                RandomStream& random) {
  const auto count = static_cast<std::size_t>(std::lround(options.seconds / options.period));
  std::vector<Eigen::Vector2d> walk;
  double heading = 0, rate = 0;
  Eigen::Vector2d q = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    rate += -rate * options.period / 0.5 + 2 * std::sqrt(options.period) * random.normal();
    heading += rate * options.period;
    q += options.speed * options.period * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    walk.push_back(q);
  }
  return walk;
}

/// Rolls the planar walk onto a ball.
inline SlidingPath path_on_ball(const std::vector<Eigen::Vector2d>& walk, double radius) {
  SlidingPath path;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // columns: two tangents, normal
  Eigen::Vector2d last = walk.front();
  for (const Eigen::Vector2d& q : walk) {
    const Eigen::Vector2d turn = (q - last) / radius;
    R = R * exp_so3({-turn.y(), turn.x(), 0});
    path.p.push_back(radius * R.col(2));
    path.n.push_back(R.col(2));
    last = q;
  }
  return path;
}

/// The point of the unrounded corner x, y, z <= 0 where plane coordinates fold onto it: the
/// quadrant u, w <= 0 is its top (z = 0); the other three shrink onto its two sides.
inline Eigen::Vector3d fold_onto_corner(double u, double w) {
  constexpr double kQuarter = std::numbers::pi / 4;
  const double rho = std::hypot(u, w);
  const double theta = std::atan2(w, u);
  const double bisector = std::remainder(theta + 3 * kQuarter, 8 * kQuarter);  // 0: mid of the top
  if (std::abs(bisector) <= kQuarter) return {u, w, 0};
  const double angle = (std::abs(bisector) - kQuarter) * 2 / 3;  // 0: top edge, pi/2: side edge
  const double along = -rho * std::cos(angle), down = -rho * std::sin(angle);
  return bisector > 0 ? Eigen::Vector3d(0, along, down) : Eigen::Vector3d(along, 0, down);
}

/// Rounds the corner: the solid shrunk by the radius, and grown by it again.
inline void add_rounded(const Eigen::Vector3d& sharp, double radius, SlidingPath& path) {
  const Eigen::Vector3d core = sharp.cwiseMin(-radius);
  path.n.push_back((sharp - core).normalized());
  path.p.push_back(core + radius * path.n.back());
}

/// Crosses the edge every 2.5 s while going to and fro along it; on the corner, that takes it over
/// the other two edges too.
inline SlidingPath path_over_edges(const std::vector<Eigen::Vector2d>& walk,
                                   const SlidingOptions& options, bool corner) {
  SlidingPath path;
  for (std::size_t i = 0; i < walk.size(); ++i) {
    const double t = options.period * static_cast<double>(i);
    const double u = 0.012 * std::sin(2 * std::numbers::pi * t / 5);
    double drift = 0.5 * walk[i].y();
    if (corner) drift = 0.01 * std::sin(drift / 0.01);  // or it would leave the corner
    const double w = drift + 0.004 * std::sin(2 * std::numbers::pi * t / 1.7);
    const Eigen::Vector3d over_edge(std::min(u, 0.0), w - 1, std::min(-u, 0.0));
    add_rounded(corner ? fold_onto_corner(u, w) : over_edge, options.edge_radius, path);
  }
  return path;
}

inline SlidingPath sliding_path(Surface surface, const SlidingOptions& options,
                                const RandomStream& random) {
  RandomStream stream = random.fork("path");
  const auto walk = planar_walk(options, stream);
  if (surface == Surface::smooth) return path_on_ball(walk, options.ball_radius);
  if (surface != Surface::flat) {
    return path_over_edges(walk, options, surface == Surface::corner);
  }
  SlidingPath path;
  for (const Eigen::Vector2d& q : walk) {
    path.p.emplace_back(q.x(), q.y(), 0);
    path.n.push_back(Eigen::Vector3d::UnitZ());
  }
  return path;
}

/// What the fingertip senses along a path, with its noise.
inline std::vector<FingerSample> samples_along(const SlidingPath& path,
                                               const SlidingOptions& options,
                                               const RandomStream& random) {
  RandomStream noise = random.fork("noise");
  std::vector<FingerSample> samples;
  const std::size_t last = path.p.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const double t = options.period * static_cast<double>(i);
    const Eigen::Vector3d& n = path.n[i];
    Eigen::Vector3d v = path.p[std::min(i + 1, last)] - path.p[i > 0 ? i - 1 : 0];
    v -= v.dot(n) * n;
    const Eigen::Vector3d u = v.norm() > 1e-12 ? v.normalized() : Eigen::Vector3d::Zero();
    const double press =
        options.normal_force * (1 + 0.3 * std::sin(2 * std::numbers::pi * 0.7 * t));
    FingerSample sample;
    sample.time = t;
    sample.f = press * (options.friction * u - n) + options.force_noise * noise.normal3();
    sample.p = path.p[i] + options.point_noise * noise.normal3();
    sample.tip_normal = (n + options.tip_noise / options.tip_radius * noise.normal3()).normalized();
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace palpate::tactile
