// SPDX-License-Identifier: Apache-2.0
#include "geometry/query/clearance.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace palpate::geometry {
namespace {

constexpr float kCell = 0.004F;           // m
constexpr float kInterpolation = 0.001F;  // m by which an interpolated distance may be off

}  // namespace

Clearance::Clearance(const geometry::DistanceField& field, const geometry::TriangleMesh& mesh)
    : per_metre_(1 / kCell), beyond_(field.beyond()) {
  const Eigen::AlignedBox3f box = geometry::bounds(mesh).cast<float>();
  origin_ = box.min().array() - beyond_;
  size_ = ((box.sizes().array() + 2 * beyond_) / kCell).ceil().cast<int>();
  const float to_corner = std::numbers::sqrt3_v<float> / 2 * kCell;
  for (int x = 0; x < size_[0]; ++x) {
    for (int y = 0; y < size_[1]; ++y) {
      for (int z = 0; z < size_[2]; ++z) {
        const Eigen::Vector3f cell = Eigen::Vector3i(x, y, z).cast<float>();
        const Eigen::Vector3f middle = origin_ + kCell * (cell.array() + 0.5F).matrix();
        values_.push_back(field.distance(middle) - to_corner - kInterpolation);
      }
    }
  }
  values_.push_back(beyond_);
  values_.push_back(std::numeric_limits<float>::infinity());
}

}  // namespace palpate::geometry
