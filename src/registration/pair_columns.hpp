// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

/// Correspondences one axis after the other in single precision, which compilers vectorise. Columns
/// end in whole words of bits or later, past `count` with nan, which agrees with nothing.
struct PairColumns {
  Eigen::ArrayXf s[3], t[3];  ///< points of source and target, in units
  Eigen::ArrayXf n[3], m[3];  ///< their normals; empty without
  int count = 0;              ///< pairs

  int size() const { return count; }
  bool has_normals() const { return n[0].size() > 0; }
};

/// Point or normal i.
inline Eigen::Vector3f at(const Eigen::ArrayXf (&axes)[3], int i) {
  return {axes[0][i], axes[1][i], axes[2][i]};
}

/// Whether the points of pairs i and j are closer than a radius in both frames, those of j's target
/// taken from pair `j_target`.
inline bool are_near(const PairColumns& c, int i, int j, float squared_radius, int j_target) {
  return (at(c.s, i) - at(c.s, j)).squaredNorm() < squared_radius &&
         (at(c.t, i) - at(c.t, j_target)).squaredNorm() < squared_radius;
}

inline bool are_near(const PairColumns& c, int i, int j, float squared_radius) {
  return are_near(c, i, j, squared_radius, j);
}

/// @param source_origin, target_origin  coordinates are taken relative to these, m
/// @param unit  m
PairColumns columns_of(const Correspondences& correspondences, const Eigen::Vector3d& source_origin,
                       const Eigen::Vector3d& target_origin, double unit, bool normals);

/// The pairs that `indices` names, in that order, into `result`, whose memory is used again.
void gather(const PairColumns& columns, const std::vector<int>& indices, PairColumns& result);

}  // namespace palpate::registration
