// SPDX-License-Identifier: Apache-2.0
#include "registration/pair_columns.hpp"

#include <algorithm>
#include <limits>

#include "registration/bitset_rows.hpp"

namespace palpate::registration {
namespace {

/// Whole words of bits, so that rows of bits need no special end.
Eigen::Index padded(std::size_t count) {
  return static_cast<Eigen::Index>((count + kWordBits - 1) / kWordBits * kWordBits);
}

void make_room(std::size_t count, Eigen::ArrayXf (&axes)[3]) {
  for (auto& axis : axes) {
    if (axis.size() < padded(count)) axis.resize(padded(count));
    std::fill(axis.data() + count, axis.data() + padded(count),
              std::numeric_limits<float>::quiet_NaN());
  }
}

void split(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin, double unit,
           Eigen::ArrayXf (&axes)[3]) {
  make_room(points.size(), axes);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = ((points[i] - origin) / unit).cast<float>();
    for (int a = 0; a < 3; ++a) axes[a][static_cast<Eigen::Index>(i)] = p[a];
  }
}

void gather(const Eigen::ArrayXf (&from)[3], const std::vector<int>& indices,
            Eigen::ArrayXf (&to)[3]) {
  make_room(indices.size(), to);
  for (int a = 0; a < 3; ++a) {
    float* next = to[a].data();
    for (const int i : indices) *next++ = from[a][i];
  }
}

}  // namespace

PairColumns columns_of(const Correspondences& correspondences, const Eigen::Vector3d& source_origin,
                       const Eigen::Vector3d& target_origin, double unit, bool normals) {
  PairColumns columns;
  columns.count = static_cast<int>(correspondences.size());
  split(correspondences.source, source_origin, unit, columns.s);
  split(correspondences.target, target_origin, unit, columns.t);
  if (!normals) return columns;
  split(correspondences.source_normals, Eigen::Vector3d::Zero(), 1, columns.n);
  split(correspondences.target_normals, Eigen::Vector3d::Zero(), 1, columns.m);
  return columns;
}

void gather(const PairColumns& columns, const std::vector<int>& indices, PairColumns& result) {
  result.count = static_cast<int>(indices.size());
  gather(columns.s, indices, result.s);
  gather(columns.t, indices, result.t);
  if (!columns.has_normals()) return;
  gather(columns.n, indices, result.n);
  gather(columns.m, indices, result.m);
}

}  // namespace palpate::registration
