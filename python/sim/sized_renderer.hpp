// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>

#include "palpate/simulation/rendering/renderer.hpp"

namespace palpate::python {

/// The renderer of one hand and object, created for the first picture and again when the size
/// changes.
class SizedRenderer {
 public:
  /// @throws BadInput as Renderer does
  simulation::Renderer& of(int width, int height, const hand::Description& hand,
                           const geometry::KnownObject& object) {
    if (!renderer_ || size_ != std::pair(width, height)) {
      renderer_.emplace(hand, object, width, height);
      size_ = {width, height};
    }
    return *renderer_;
  }

 private:
  std::optional<simulation::Renderer> renderer_;
  std::pair<int, int> size_;  ///< of its pictures, pixels
};

}  // namespace palpate::python
