// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {
namespace {

constexpr double kStage = 0.01;  // m of path
constexpr int kMinStages = 8;    // of a piece
constexpr int kBisections = 40;

/// A stretch of a piece that is passed with constant acceleration along the path.
struct Stage {
  const PathPiece* piece;
  double start, length;  // m of the piece's path
  Coordinates tangent, tangent_end;
};

struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  void cut(double a, double b) {
    low = std::max(low, a);
    high = std::min(high, b);
  }
};

std::vector<Stage> stages_of(const std::vector<PathPiece>& path) {
  std::vector<Stage> stages;
  for (const PathPiece& piece : path) {
    const int count = std::max(kMinStages, static_cast<int>(std::ceil(piece.length / kStage)));
    const double length = piece.length / count;
    for (int i = 0; i < count; ++i) {
      stages.push_back(
          {&piece, i * length, length, piece.tangent(i * length), piece.tangent((i + 1) * length)});
    }
  }
  return stages;
}

/// Largest squared path speed at which the speed limits hold all along a stage.
double speed_bound(const Stage& stage, const Coordinates& speed) {
  constexpr double kTiny = 1e-9;
  const auto largest = stage.tangent.cwiseAbs().cwiseMax(stage.tangent_end.cwiseAbs());
  return (speed.array() / largest.array().max(kTiny)).square().minCoeff();
}

/// Path accelerations within every coordinate's limit at both ends of a stage that starts with
/// squared speed z. In between all is linear in the way: tangent * acceleration + bend * z.
Interval accelerations(const Stage& stage, double z, const Coordinates& limit) {
  constexpr double kFlat = 1e-9;
  Interval interval;
  const Coordinates& bend = stage.piece->bend;
  const Coordinates slope_end = stage.tangent_end + 2 * stage.length * bend;
  for (Eigen::Index i = 0; i < bend.size(); ++i) {
    for (const double slope : {stage.tangent[i], slope_end[i]}) {
      const double given = bend[i] * z, room = limit[i];
      if (std::abs(slope) > kFlat) {
        const double a = (-room - given) / slope, b = (room - given) / slope;
        interval.cut(std::min(a, b), std::max(a, b));
      } else if (std::abs(given) > room) {
        interval.cut(1, -1);  // no acceleration along the path helps
      }
    }
  }
  return interval;
}

/// Whether a stage that starts with z can end with a squared speed in 0..z_end.
bool can_reach(const Stage& stage, double z, double z_end, const Coordinates& limit) {
  Interval interval = accelerations(stage, z, limit);
  interval.cut(-z / (2 * stage.length), (z_end - z) / (2 * stage.length));
  return interval.low <= interval.high;
}

double largest_start(const Stage& stage, double bound, double z_end, const Coordinates& limit) {
  if (can_reach(stage, bound, z_end, limit)) return bound;
  double low = 0, high = bound;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (can_reach(stage, middle, z_end, limit) ? low : high) = middle;
  }
  return low;
}

bool has_corner(const Stage& before, const Stage& after, const Coordinates& metric) {
  constexpr double kBend = 1e-6;
  return distance(before.tangent_end, after.tangent, metric) > kBend;
}

/// Largest squared speed at the start of each stage, and at the end, from which the end can be
/// reached at rest.
std::vector<double> backward(const std::vector<Stage>& stages, const CoordinateLimits& limits,
                             const Coordinates& metric) {
  std::vector<double> z(stages.size() + 1, 0.0);
  for (std::size_t k = stages.size(); k-- > 1;) {
    if (has_corner(stages[k - 1], stages[k], metric)) continue;
    const double bound =
        std::min(speed_bound(stages[k - 1], limits.speed), speed_bound(stages[k], limits.speed));
    z[k] = largest_start(stages[k], bound, z[k + 1], limits.acceleration);
  }
  return z;
}

/// Squared speeds at the ends of the stages, from rest, accelerating as much as can be.
std::vector<double> forward(const std::vector<Stage>& stages, const std::vector<double>& bounds,
                            const CoordinateLimits& limits) {
  std::vector<double> z(stages.size() + 1, 0.0);
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const Interval allowed = accelerations(stages[k], z[k], limits.acceleration);
    z[k + 1] = std::clamp(z[k] + 2 * stages[k].length * allowed.high, 0.0, bounds[k + 1]);
  }
  return z;
}

}  // namespace

std::vector<Coordinates> time_path(const std::vector<PathPiece>& path, const MotionLimits& limits,
                                   const Coordinates& metric, double dt) {
  const CoordinateLimits by_coordinate{speed_limits(limits, metric.size()),
                                       acceleration_limits(limits, metric.size())};
  return time_path(path, by_coordinate, metric, dt);
}

std::vector<Coordinates> time_path(const std::vector<PathPiece>& path,
                                   const CoordinateLimits& limits, const Coordinates& metric,
                                   double dt) {
  const std::vector<Stage> stages = stages_of(path);
  const std::vector<double> z = forward(stages, backward(stages, limits, metric), limits);
  std::vector<Coordinates> samples;
  double start = 0, time = 0;
  for (std::size_t k = 0; k < stages.size(); ++k) {
    const Stage& stage = stages[k];
    const double v = std::sqrt(z[k]), v_end = std::sqrt(z[k + 1]);
    const double duration = 2 * stage.length / (v + v_end);
    const double acceleration = (v_end - v) / duration;
    for (; time < start + duration; time = static_cast<double>(samples.size()) * dt) {
      const double t = time - start;
      samples.push_back(stage.piece->at(stage.start + t * (v + 0.5 * t * acceleration)));
    }
    start += duration;
  }
  if (!path.empty()) samples.push_back(path.back().at(path.back().length));
  return samples;
}

}  // namespace palpate::planning
