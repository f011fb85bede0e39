// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "relocate_scene.hpp"

namespace palpate::simulation {

struct RelocateModel::Impl {
  RelocateScene scene;
  RelocateAction center, half_range;
  double start_height = 0;
};

}  // namespace palpate::simulation
