// SPDX-License-Identifier: Apache-2.0
#include "registration/pairing_rates.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "palpate/core/se3.hpp"
#include "registration/bitset_rows.hpp"

namespace palpate::registration {
namespace {

constexpr int kMostCells = 48;  // an axis
constexpr double kBall3 = 4 * std::numbers::pi / 3;
constexpr double kBall5 = 8 * std::numbers::pi * std::numbers::pi / 15;

constexpr int kBatch = 256;  // sources that are moved at a time

struct Batch {
  float points[3][kBatch];
  int indices[kBatch], cells[kBatch];
};

/// A pose, and the grid that it leads to.
struct ToGrid {
  Eigen::Matrix3f R;
  Eigen::Vector3f t, low;
  Eigen::Array3i cells;
  float per_side;
};

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

/// Drops those in cells without targets, mostly nearly all.
/// @return how many are left
int keep_occupied(Batch& batch, int count, const std::vector<std::uint64_t>& occupied) {
  int kept = 0;
  for (int k = 0; k < count; ++k) {
    const int cell = batch.cells[k];
    const std::uint64_t word = occupied[static_cast<std::size_t>(cell) / kWordBits];
    batch.indices[kept] = batch.indices[k];
    batch.cells[kept] = cell;
    kept += static_cast<int>(word >> (cell % kWordBits) & 1);
  }
  return kept;
}

}  // namespace

PairingRates::PairingRates(const PairColumns& columns, double chord_bound, double radius)
    : columns_(columns) {
  Eigen::Vector3f high;
  for (int a = 0; a < 3; ++a) {
    low_[a] = columns.t[a].head(columns.size()).minCoeff();
    high[a] = columns.t[a].head(columns.size()).maxCoeff();
  }
  const double fine = radius * std::cbrt(kBall3);
  const double side =
      std::max(fine, static_cast<double>((high - low_).maxCoeff()) / (kMostCells - 1));
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

int PairingRates::propose(RandomStream& random, Eigen::Isometry3d& T) const {
  const auto size = static_cast<std::size_t>(columns_.size());
  const int source = static_cast<int>(random.index(size)),
            target = static_cast<int>(random.index(size));
  T.linear() = random.rotation();
  if (chord_squared_ > 0) {
    const double reach = std::sqrt(static_cast<double>(chord_squared_) * random.uniform());
    const double direction = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::Matrix3d frame = frame_with_z(at(columns_.m, target).cast<double>());
    const Eigen::Vector3d tilted =
        frame * Eigen::Vector3d(reach * std::cos(direction), reach * std::sin(direction), 1);
    const Eigen::AngleAxisd roll(random.uniform(0, 2 * std::numbers::pi), Eigen::Vector3d::UnitZ());
    T.linear() = frame_with_z(tilted.normalized()) * roll.toRotationMatrix() *
                 frame_with_z(at(columns_.n, source).cast<double>()).transpose();
  }
  const auto half = 0.5 * static_cast<double>(side_);
  Eigen::Vector3d there = at(columns_.t, target).cast<double>();
  for (int a = 0; a < 3; ++a) there[a] += random.uniform(-half, half);
  T.translation() = there - T.linear() * at(columns_.s, source).cast<double>();
  return source;
}

void PairingRates::agreements(const Eigen::Isometry3d& T, const Strided& sources,
                              std::vector<int>& counts) const {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const ToGrid to_grid{R, T.translation().cast<float>(), low_, cells_, per_side_};
  const int size = columns_.size();
  Batch batch;
  int i = sources.first % size;
  for (int done = 0; done < sources.count; done += kBatch) {
    const int count = std::min(kBatch, sources.count - done);
    for (int k = 0; k < count; ++k) {
      for (int a = 0; a < 3; ++a) batch.points[a][k] = columns_.s[a][i];
      batch.indices[k] = i;
      i += sources.step;
      if (i >= size) i %= size;
    }
    find_cells(batch, count, to_grid);
    const int occupied = keep_occupied(batch, count, occupied_);
    for (int k = 0; k < occupied; ++k) {
      const int found = agreements_in(batch.cells[k], R, batch.indices[k]);
      if (found > 0) counts.push_back(found);
    }
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
