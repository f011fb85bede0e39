// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lanes.hpp"
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

  /// The same for four points at a time, as places for value_at(); nowhere where a point is not
  /// looked at.
  Ints4 places_of(Floats4 x, Floats4 y, Floats4 z, Ints4 looked_at) const {
    const auto cell = [this](Floats4 p, int axis) {
      return __builtin_convertvector((p - origin_[axis]) * per_metre_, Ints4);
    };
    const Ints4 i = cell(x, 0), j = cell(y, 1), k = cell(z, 2);
    const Ints4 inside = (x >= origin_[0]) & (y >= origin_[1]) & (z >= origin_[2]) &
                         (i < size_[0]) & (j < size_[1]) & (k < size_[2]);
    const Ints4 place = ((inside & i) * size_[1] + (inside & j)) * size_[2] + (inside & k);
    const auto outside = static_cast<std::int32_t>(values_.size()) - 2;
    return chosen(looked_at, chosen(inside, place, Ints4{} + outside), Ints4{} + (outside + 1));
  }
  /// As at_least(); infinite nowhere.
  float value_at(std::int32_t place) const { return values_[static_cast<std::size_t>(place)]; }

 private:
  Eigen::Vector3f origin_;
  Eigen::Array3i size_;
  float per_metre_, beyond_;
  std::vector<float> values_;  // of all cells, outside them, and nowhere
};

}  // namespace palpate::geometry
