// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "targets.hpp"

namespace palpate::fuzz {

/// Recordings, changed within and sealed again, and Minari's data sets.
std::vector<Target> hdf5_targets();

}  // namespace palpate::fuzz
