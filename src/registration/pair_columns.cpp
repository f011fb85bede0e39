// SPDX-License-Identifier: Apache-2.0
#include "registration/pair_columns.hpp"

namespace palpate::registration {
namespace {

void split(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin, double unit,
           Eigen::ArrayXf (&axes)[3]) {
  const auto count = static_cast<Eigen::Index>(points.size());
  for (auto& axis : axes) axis.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3f p = ((points[static_cast<std::size_t>(i)] - origin) / unit).cast<float>();
    for (int a = 0; a < 3; ++a) axes[a][i] = p[a];
  }
}

void gather(const Eigen::ArrayXf (&from)[3], const std::vector<int>& indices,
            Eigen::ArrayXf (&to)[3]) {
  for (int a = 0; a < 3; ++a) {
    to[a].resize(static_cast<Eigen::Index>(indices.size()));
    float* next = to[a].data();
    for (const int i : indices) *next++ = from[a][i];
  }
}

}  // namespace

PairColumns columns_of(const Correspondences& correspondences, const Eigen::Vector3d& source_origin,
                       const Eigen::Vector3d& target_origin, double unit, bool normals) {
  PairColumns columns;
  split(correspondences.source, source_origin, unit, columns.s);
  split(correspondences.target, target_origin, unit, columns.t);
  if (!normals) return columns;
  split(correspondences.source_normals, Eigen::Vector3d::Zero(), 1, columns.n);
  split(correspondences.target_normals, Eigen::Vector3d::Zero(), 1, columns.m);
  return columns;
}

void gather(const PairColumns& columns, const std::vector<int>& indices, PairColumns& result) {
  gather(columns.s, indices, result.s);
  gather(columns.t, indices, result.t);
  if (!columns.has_normals()) return;
  gather(columns.n, indices, result.n);
  gather(columns.m, indices, result.m);
}

}  // namespace palpate::registration
