// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/solids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "palpate/core/angle.hpp"

namespace palpate::geometry {
namespace {

/// |p| less the radius of |x/a|^(2/e) + |y/b|^(2/e) = 1 along p.
double superellipse(const Eigen::Vector2d& p, double a, double b, double e) {
  const double f = std::pow(std::abs(p.x()) / a, 2 / e) + std::pow(std::abs(p.y()) / b, 2 / e);
  if (f < 1e-12) return -std::min(a, b);
  return p.norm() * (1 - std::pow(f, -e / 2));
}

/// Catmull-Rom spline through even samples, at u from 0 to their number less 1.
double spline(const std::vector<double>& samples, double u) {
  const auto last = static_cast<int>(samples.size()) - 1;
  const int i = std::clamp(static_cast<int>(std::floor(u)), 0, last - 1);
  const double t = std::clamp(u - i, 0.0, 1.0);
  const auto at = [&](int k) { return samples[static_cast<std::size_t>(std::clamp(k, 0, last))]; };
  const double a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

}  // namespace

Solid superquadric(const Eigen::Vector3d& half, double e1, double e2) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Array3d q = (p.array() / half.array()).abs();
    const double round = std::pow(q.x(), 2 / e2) + std::pow(q.y(), 2 / e2);
    const double f = std::pow(round, e2 / e1) + std::pow(q.z(), 2 / e1);
    if (f < 1e-12) return -half.minCoeff();
    return p.norm() * (1 - std::pow(f, -e1 / 2));
  };
}

Solid lofted(const Loft& loft) {
  return [=](const Eigen::Vector3d& p) {
    const double along = std::clamp(p.z() / loft.h, -1.0, 1.0);
    const double scale = 1 - loft.taper * (along + 1) / 2;
    const Eigen::Vector2d middle(loft.bend * (1 - along * along), 0);
    const Eigen::Rotation2Dd turn(-loft.twist * along);
    const Eigen::Vector2d q = turn * Eigen::Vector2d(p.head<2>() - middle);
    const double side = superellipse(q, scale * loft.a, scale * loft.b, loft.e);
    return std::max(side, std::abs(p.z()) - loft.h);
  };
}

Solid revolved(std::vector<double> radii, double h) {
  return [radii = std::move(radii), h](const Eigen::Vector3d& p) {
    const double steps = static_cast<double>(radii.size() - 1);
    const double u = std::clamp((p.z() / h + 1) / 2, 0.0, 1.0) * steps;
    const double slope =
        (spline(radii, u + 0.05) - spline(radii, u - 0.05)) / 0.1 * steps / (2 * h);
    const double side = (p.head<2>().norm() - spline(radii, u)) / std::sqrt(1 + slope * slope);
    return std::max(side, std::abs(p.z()) - h);
  };
}

Solid handle(double x, double reach, double z0, double z1, double radius) {
  constexpr int kPieces = 16;
  std::array<Eigen::Vector3d, kPieces + 1> path;
  for (int i = 0; i <= kPieces; ++i) {
    const double angle = kPi * (static_cast<double>(i) / kPieces - 0.5);
    path[static_cast<std::size_t>(i)] << x + reach * std::cos(angle), 0,
        (z0 + z1) / 2 + (z1 - z0) / 2 * std::sin(angle);
  }
  return [path, radius](const Eigen::Vector3d& p) {
    double least = 1;
    for (std::size_t i = 0; i < kPieces; ++i) {
      const Eigen::Vector3d way = path[i + 1] - path[i];
      const double share = std::clamp((p - path[i]).dot(way) / way.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (p - path[i] - share * way).norm());
    }
    return least - radius;
  };
}

Solid moved(const Eigen::Isometry3d& T, Solid solid) {
  return [inverse = T.inverse(), solid = std::move(solid)](const Eigen::Vector3d& p) {
    return solid(inverse * p);
  };
}

Solid joined(Solid a, Solid b, double fillet) {
  return [a = std::move(a), b = std::move(b), fillet](const Eigen::Vector3d& p) {
    const double da = a(p), db = b(p);
    const double near = std::max(fillet - std::abs(da - db), 0.0);
    return std::min(da, db) - near * near / (4 * fillet);
  };
}

Solid cut(Solid a, Solid b) {
  return [a = std::move(a), b = std::move(b)](const Eigen::Vector3d& p) {
    return std::max(a(p), -b(p));
  };
}

Solid hollowed(Solid solid, double wall, double top) {
  return [solid = std::move(solid), wall, top](const Eigen::Vector3d& p) {
    const double d = solid(p);
    return std::max({d, -(d + wall), p.z() - top});
  };
}

Solid scanned(Solid solid, double rms, RandomStream random) {
  struct Wave {
    Eigen::Vector3d k;
    double phase;
  };
  constexpr int kWaves = 12;
  std::array<Wave, kWaves> waves;
  for (Wave& wave : waves) {
    const double length = random.uniform(0.006, 0.025);
    wave.k = 2 * kPi / length * random.unit_vector();
    wave.phase = random.uniform(0, 2 * kPi);
  }
  const double size = rms * std::sqrt(2.0 / kWaves);
  return [solid = std::move(solid), waves, size](const Eigen::Vector3d& p) {
    double noise = 0;
    for (const Wave& wave : waves) noise += std::sin(wave.k.dot(p) + wave.phase);
    return solid(p) + size * noise;
  };
}

}  // namespace palpate::geometry
