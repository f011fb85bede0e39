// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::geometry {

/// What is known of points beside their place: one column a point, of any kind.
using Features = Eigen::MatrixXf;

struct Match {
  int source = -1, target = -1;
};

/// Pairs of columns that are each other's nearest, by source index; of equally near ones the first.
/// Features are compared as integers of 14 bits and a sign, the longest column being 2^14 long: the
/// same on every machine.
/// @param threads  the result does not depend on them
/// @throws BadInput for columns of different lengths, and for features that are not finite
std::vector<Match> mutual_matches(const Features& source, const Features& target, int threads = 1);

}  // namespace palpate::geometry
