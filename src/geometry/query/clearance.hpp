// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"
#include "palpate/geometry/query/distance_field.hpp"

namespace palpate::geometry {

/// A coarse lower bound of the distance to an object, small enough to stay in the processor's
/// cache: most places are so clear of the object that its distance field need not be looked up.
class Clearance {
 public:
  Clearance(const geometry::DistanceField& field, const geometry::TriangleMesh& mesh);

  /// At most the distance from p (object's frame) to the surface, m; far outside the bounds
  /// beyond().
  float at_least(const Eigen::Vector3f& p) const {
    const Eigen::Array3i cell = ((p - origin_) * per_metre_).array().cast<int>();
    const bool inside = (p.array() >= origin_.array()).all() && (cell < size_).all();
    return inside ? values_[static_cast<std::size_t>((cell[0] * size_[1] + cell[1]) * size_[2] +
                                                     cell[2])]
                  : beyond_;
  }

 private:
  Eigen::Vector3f origin_;
  Eigen::Array3i size_;
  float per_metre_, beyond_;
  std::vector<float> values_;
};

}  // namespace palpate::geometry
