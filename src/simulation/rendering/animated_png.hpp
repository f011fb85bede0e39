// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/simulation/rendering/image.hpp"

namespace palpate::simulation {

/// The bytes of a PNG file.
std::string encode_png(const Image& image);

/// The bytes of an animated PNG file: at least one picture, all of one size. Colours are rounded
/// down to 64 levels; what does not change from one picture to the next is left out.
std::string encode_animation(const std::vector<Image>& images, double seconds);

}  // namespace palpate::simulation
