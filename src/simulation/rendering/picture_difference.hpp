// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/simulation/rendering/image.hpp"

namespace palpate::simulation {

/// Part of a picture, pixels.
struct Rectangle {
  int x = 0, y = 0, width = 1, height = 1;
};

/// Where two pictures of one size differ; one pixel where they do not.
Rectangle difference(const Image& a, const Image& b);

}  // namespace palpate::simulation
