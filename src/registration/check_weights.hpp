// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace palpate::registration {

/// @throws BadInput for weights that are not one a pair (or none), negative or not finite
void check_weights(const std::vector<double>& weights, std::size_t pairs);

}  // namespace palpate::registration
