// SPDX-License-Identifier: Apache-2.0
#include "registration/pairing_rates.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

#include "palpate/core/se3.hpp"
#include "registration/bitset_rows.hpp"

namespace palpate::registration {
namespace {

constexpr int kMaxCells = 48;  // an axis
constexpr double kBall3 = 4 * std::numbers::pi / 3;
constexpr double kBall5 = 8 * std::numbers::pi * std::numbers::pi / 15;

constexpr int kBatch = 256;  // sources that are moved at a time

struct Batch {
  const float* points[3];  // one axis after the other
  int indices[kBatch], cells[kBatch];
};

/// A pose, and the grid that it leads to.
struct ToGrid {
  Eigen::Matrix3f R;
  Eigen::Vector3f t, low;
  Eigen::Array3i cells;
  float per_side;
};

/// first, first + step, .., from the start again past the end.
/// @return the source after them
int copy(const PairColumns& columns, const Strided& sources, float (*points)[kBatch]) {
  int i = sources.first;
  for (int k = 0; k < sources.count; ++k) {
    for (int a = 0; a < 3; ++a) points[a][k] = columns.s[a][i];
    i += sources.step;
    if (i >= columns.size()) i %= columns.size();
  }
  return i;
}

/// Which cells the points are moved to; the one past the last outside of the grid.
PALPATE_WIDE void find_cells(Batch& batch, int count, const ToGrid& to) {
  float r[3][3], t[3], low[3], most[3];
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) r[a][b] = to.R(a, b);
    t[a] = to.t[a], low[a] = to.low[a], most[a] = static_cast<float>(to.cells[a]);
  }
  const float per_side = to.per_side;
  const int columns = to.cells[1], layers = to.cells[2];
  const int outside = to.cells.prod();
  const float *sx = batch.points[0], *sy = batch.points[1], *sz = batch.points[2];
  int* __restrict cells = batch.cells;
  for (int k = 0; k < count; ++k) {
    const float x =
        (r[0][0] * sx[k] + r[0][1] * sy[k] + r[0][2] * sz[k] + t[0] - low[0]) * per_side;
    const float y =
        (r[1][0] * sx[k] + r[1][1] * sy[k] + r[1][2] * sz[k] + t[1] - low[1]) * per_side;
    const float z =
        (r[2][0] * sx[k] + r[2][1] * sy[k] + r[2][2] * sz[k] + t[2] - low[2]) * per_side;
    // Before the conversion: what is far outside, or no number, has no int.
    const bool inside =
        (x >= 0) & (x < most[0]) & (y >= 0) & (y < most[1]) & (z >= 0) & (z < most[2]);
    const int i = static_cast<int>(inside ? x : 0), j = static_cast<int>(inside ? y : 0),
              l = static_cast<int>(inside ? z : 0);
    cells[k] = inside ? (i * columns + j) * layers + l : outside;
  }
}

/// Lists those in cells that hold targets, mostly few.
/// @return how many there are
int list_occupied(Batch& batch, int count, const std::vector<std::uint64_t>& occupied) {
  int kept = 0;
  for (int k = 0; k < count; ++k) {
    const auto cell = static_cast<unsigned>(batch.cells[k]);
    batch.indices[kept] = k;
    kept += static_cast<int>(occupied[cell / kWordBits] >> (cell % kWordBits) & 1);
  }
  return kept;
}

/// Of 0..1, small ones more often than others: as many from x to 2 x as from 2 x to 4 x, above
/// this.
constexpr double kSmall = 1e-4;
const double kLogRange = std::log(1 + 1 / kSmall);

double often_small(RandomStream& random) {
  return kSmall * std::expm1(kLogRange * random.uniform());
}

/// Its density.
double density(double x) { return 1 / (kLogRange * (x + kSmall)); }

/// How far a turn is from half turns, 0 to 1 for a quarter.
double off_half_turns(double angle) {
  return std::abs(std::remainder(angle, std::numbers::pi)) / (std::numbers::pi / 2);
}

/// Of a mixture of chance and some other densities over its own.
double mixed_weight(double densities, std::size_t count) {
  return count > 0 ? 1 / (0.5 + 0.5 * densities / static_cast<double>(count)) : 1;
}

}  // namespace

PairingRates::PairingRates(const PairColumns& columns, double chord_bound, double radius,
                           std::vector<ThinAxes> axes)
    : columns_(columns), axes_(std::move(axes)) {
  Eigen::Vector3f high;
  for (int a = 0; a < 3; ++a) {
    low_[a] = columns.t[a].head(columns.size()).minCoeff();
    high[a] = columns.t[a].head(columns.size()).maxCoeff();
  }
  const double fine = radius * std::cbrt(kBall3);
  const double side =
      std::max(fine, static_cast<double>((high - low_).maxCoeff()) / (kMaxCells - 1));
  side_ = static_cast<float>(side);
  per_side_ = 1 / side_;
  coarseness_ = std::pow(side / fine, 3);
  if (chord_bound > 0) {
    const double squared = kBall5 / kBall3 / std::numbers::pi;  // a disc of this makes up the rest
    chord_squared_ = static_cast<float>(squared * radius * radius * chord_bound * chord_bound);
  }
  cells_ = ((high - low_) * per_side_).array().cast<int>() + 1;
  std::vector<int> cell_of(static_cast<std::size_t>(columns.size()));
  first_.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
  occupied_.assign(first_.size() / kWordBits + 1, 0);
  for (int j = 0; j < columns.size(); ++j) {
    const int c = cell(at(columns.t, j));
    cell_of[static_cast<std::size_t>(j)] = c;
    ++first_[static_cast<std::size_t>(c)];
    occupied_[static_cast<std::size_t>(c / kWordBits)] |= std::uint64_t{1} << (c % kWordBits);
  }
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  targets_.resize(cell_of.size());
  for (int j = columns.size() - 1; j >= 0; --j) {
    const auto c = static_cast<std::size_t>(cell_of[static_cast<std::size_t>(j)]);
    targets_[static_cast<std::size_t>(--first_[c])] = j;
  }
}

/// -1 outside of the grid.
int PairingRates::cell(const Eigen::Vector3f& p) const {
  const Eigen::Vector3f x = (p - low_) * per_side_;
  // Before the conversion: what is far outside, or no number, has no int.
  const bool inside = (x.array() >= 0).all() && (x.array() < cells_.cast<float>()).all();
  if (!inside) return -1;
  const Eigen::Array3i at_cell = x.array().cast<int>();
  return (at_cell[0] * cells_[1] + at_cell[1]) * cells_[2] + at_cell[2];
}

ProposedPose PairingRates::propose(RandomStream& random) const {
  const auto size = static_cast<std::size_t>(columns_.size());
  ProposedPose pose;
  pose.source = static_cast<int>(random.index(size));
  const int target = static_cast<int>(random.index(size));
  const bool aligns = !axes_.empty() && random.uniform() < 0.5;
  const ThinAxes* aligned = aligns ? &axes_[random.index(axes_.size())] : nullptr;
  if (chord_squared_ > 0) {
    const double reach = std::sqrt(static_cast<double>(chord_squared_) * random.uniform());
    const double direction = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::Matrix3d frame = frame_with_z(at(columns_.m, target).cast<double>());
    const Eigen::Vector3d tilted =
        frame * Eigen::Vector3d(reach * std::cos(direction), reach * std::sin(direction), 1);
    const Eigen::Vector3d normal = tilted.normalized();
    const double angle = roll(pose.source, normal, aligned, random, pose.weight);
    pose.T.linear() = frame_with_z(normal) *
                      Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                      frame_with_z(at(columns_.n, pose.source).cast<double>()).transpose();
  } else {
    pose.T.linear() = turn(aligned, random);
    pose.weight = weight_of(pose.T.linear());
  }
  const auto half = 0.5 * static_cast<double>(side_);
  Eigen::Vector3d there = at(columns_.t, target).cast<double>();
  for (int a = 0; a < 3; ++a) there[a] += random.uniform(-half, half);
  pose.T.translation() = there - pose.T.linear() * at(columns_.s, pose.source).cast<double>();
  return pose;
}

/// Any rotation, or one after which a pair of axes lies on one another, the closer the more often.
Eigen::Matrix3d PairingRates::turn(const ThinAxes* aligned, RandomStream& random) const {
  if (!aligned) return random.rotation();
  const double cosine = 1 - often_small(random), sine = std::sqrt(1 - cosine * cosine),
               azimuth = random.uniform(0, 2 * std::numbers::pi),
               sign = random.uniform() < 0.5 ? -1 : 1;
  const Eigen::Vector3d off(sine * std::cos(azimuth), sine * std::sin(azimuth), sign * cosine);
  const Eigen::Vector3d to = frame_with_z(aligned->target) * off;
  const Eigen::AngleAxisd roll(random.uniform(0, 2 * std::numbers::pi), Eigen::Vector3d::UnitZ());
  return frame_with_z(to.normalized()) * roll.toRotationMatrix() *
         frame_with_z(aligned->source).transpose();
}

/// Of a rotation among all, over how often propose() takes it.
double PairingRates::weight_of(const Eigen::Matrix3d& R) const {
  double densities = 0;
  for (const auto& [source, target] : axes_) {
    densities += density(std::max(0.0, 1 - std::abs(target.dot(R * source))));
  }
  return mixed_weight(densities, axes_.size());
}

/// An angle about the normals of a pair that lie on one another: any, or one that lays a pair of
/// axes on one another, as far as they lie across.
/// @param weight  of the angle
double PairingRates::roll(int source, const Eigen::Vector3d& normal, const ThinAxes* aligned,
                          RandomStream& random, double& weight) const {
  constexpr double kAcross = 0.3;
  double angle = random.uniform(0, 2 * std::numbers::pi), densities = 0;
  if (axes_.empty()) return angle;
  const Eigen::Matrix3d from = frame_with_z(at(columns_.n, source).cast<double>()).transpose(),
                        to = frame_with_z(normal).transpose();
  std::vector<std::optional<double>> best;  // angle for each pair of axes, or half a turn more
  for (const auto& axes : axes_) {
    const Eigen::Vector2d a = (from * axes.source).head<2>(), b = (to * axes.target).head<2>();
    const bool across = std::min(a.norm(), b.norm()) > kAcross;
    best.push_back(across ? std::optional(std::atan2(b[1], b[0]) - std::atan2(a[1], a[0]))
                          : std::nullopt);
    if (&axes != aligned || !across) continue;
    const double half_turn = random.uniform() < 0.5 ? 0 : std::numbers::pi,
                 sign = random.uniform() < 0.5 ? -1 : 1;
    angle = *best.back() + half_turn + sign * std::numbers::pi / 2 * often_small(random);
  }
  for (const auto& at_best : best) {
    densities += at_best ? density(off_half_turns(angle - *at_best)) : 1;
  }
  weight = mixed_weight(densities, axes_.size());
  return angle;
}

void PairingRates::agreements(const Eigen::Isometry3d& T, const Strided& sources,
                              std::vector<int>& counts) const {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const ToGrid to_grid{R, T.translation().cast<float>(), low_, cells_, per_side_};
  const int size = columns_.size();
  Batch batch;
  float copies[3][kBatch];
  int i = sources.first % size;
  for (int done = 0; done < sources.count;) {
    int count = std::min(kBatch, sources.count - done);
    const int first = i;
    if (sources.step == 1) {
      count = std::min(count, size - i);
      for (int a = 0; a < 3; ++a) batch.points[a] = columns_.s[a].data() + i;
      i = (i + count) % size;
    } else {
      i = copy(columns_, {first, sources.step, count}, copies);
      for (int a = 0; a < 3; ++a) batch.points[a] = copies[a];
    }
    find_cells(batch, count, to_grid);
    const int occupied = list_occupied(batch, count, occupied_);
    for (int k = 0; k < occupied; ++k) {
      const int at_batch = batch.indices[k];
      const int source = (first + at_batch * sources.step) % size;
      const int found = agreements_in(batch.cells[at_batch], R, source);
      if (found > 0) counts.push_back(found);
    }
    done += count;
  }
}

int PairingRates::agreements_in(int cell, const Eigen::Matrix3f& R, int source) const {
  const int begin = first_[static_cast<std::size_t>(cell)],
            end = first_[static_cast<std::size_t>(cell) + 1];
  if (!(chord_squared_ > 0) || begin == end) return end - begin;
  const Eigen::Vector3f n = R * at(columns_.n, source);
  int total = 0;
  for (int k = begin; k < end; ++k) {
    const Eigen::Vector3f m = at(columns_.m, targets_[static_cast<std::size_t>(k)]);
    total += (n - m).squaredNorm() < chord_squared_;
  }
  return total;
}

double power_of_mean(const std::vector<int>& counts, int all, int power) {
  if (static_cast<int>(counts.size()) < power) return 0;
  std::vector<double> products(static_cast<std::size_t>(power) + 1, 0);
  products[0] = 1;
  for (const int count : counts) {
    for (std::size_t q = products.size() - 1; q > 0; --q) products[q] += count * products[q - 1];
  }
  double mean = products.back();
  for (int q = 0; q < power; ++q) mean *= (q + 1.0) / (all - q);
  return mean;
}

}  // namespace palpate::registration
