// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "palpate/simulation/rendering/renderer.hpp"

namespace palpate::simulation {

/// The renderer of one hand and object, made for the first picture, and anew for one of another
/// size.
class SizedRenderer {
 public:
  /// @throws BadInput as Renderer does
  Renderer& of(int width, int height, const hand::Description& hand,
               const geometry::KnownObject& object) {
    if (!renderer_ || size_ != std::pair(width, height)) {
      renderer_.emplace(hand, object, width, height);
      size_ = {width, height};
    }
    return *renderer_;
  }

 private:
  std::optional<Renderer> renderer_;
  std::pair<int, int> size_;  ///< of its pictures, pixels
};

}  // namespace palpate::simulation
