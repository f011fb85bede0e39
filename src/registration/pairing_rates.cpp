// SPDX-License-Identifier: Apache-2.0
#include "registration/pairing_rates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::registration {
namespace {

constexpr int kMostCells = 48;  // an axis
constexpr double kBall3 = 4 * std::numbers::pi / 3;
constexpr double kBall5 = 8 * std::numbers::pi * std::numbers::pi / 15;

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
  for (int j = 0; j < columns.size(); ++j) {
    const int c = cell(at(columns.t, j));
    cell_of[static_cast<std::size_t>(j)] = c;
    ++first_[static_cast<std::size_t>(c)];
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
  const Eigen::Vector3f t = T.translation().cast<float>();
  const int size = columns_.size();
  int i = sources.first % size;
  for (int k = 0; k < sources.count; ++k) {
    const int c = cell(R * at(columns_.s, i) + t);
    const int count = c < 0 ? 0 : agreements_in(c, R, i);
    if (count > 0) counts.push_back(count);
    i = (i + sources.step) % size;
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
