// SPDX-License-Identifier: Apache-2.0
#include "simulation/rendering/picture_difference.hpp"

#include <algorithm>
#include <cstddef>

namespace palpate::simulation {

Rectangle difference(const Image& a, const Image& b) {
  int left = a.width, right = -1, top = a.height, bottom = -1;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const auto at = 3 * (static_cast<std::ptrdiff_t>(y) * a.width + x);
      if (std::equal(a.rgb.begin() + at, a.rgb.begin() + at + 3, b.rgb.begin() + at)) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  }
  if (right < 0) return {};
  return {left, top, right - left + 1, bottom - top + 1};
}

}  // namespace palpate::simulation
