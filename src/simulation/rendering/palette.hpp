// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "palpate/simulation/rendering/image.hpp"

namespace palpate::simulation {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// Few colours that stand for all of some pictures: median cut (Heckbert, SIGGRAPH 1982) over
/// colours of 64 levels, by the number of pixels that have them.
class Palette {
 public:
  Palette(const std::vector<Image>& images, std::size_t most);

  [[nodiscard]] const std::vector<Color>& colors() const { return colors_; }

  /// Which of them stands for a colour of the pictures.
  [[nodiscard]] std::uint8_t index_of(const std::uint8_t* rgb) const;

 private:
  std::vector<Color> colors_;
  std::vector<std::uint8_t> index_of_cell_;
};

}  // namespace palpate::simulation
