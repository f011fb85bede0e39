// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common.hpp"

namespace palpate::app {

/// Grasps the built-in objects with a kinematic hand and shows how the pose becomes known with the
/// number of contacts; writes the figure and a file of contacts of the mug.
int demonstrate_localize(const CommonOptions& common);

}  // namespace palpate::app
