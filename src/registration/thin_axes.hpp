// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "registration/pair_columns.hpp"

namespace palpate::registration {

/// Along which both the sources and the targets are long, or thin, compared with the others.
struct ThinAxes {
  Eigen::Vector3d source, target;  ///< of length 1, with any sign
};

/// Those of long things (pencils), flat ones (sheets) or both (rulers); none of others.
std::vector<ThinAxes> thin_axes(const PairColumns& columns);

}  // namespace palpate::registration
