// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/simulation/rendering/image.hpp"

namespace palpate::simulation {

/// The bytes of an animated GIF file (GIF89a): at least one picture, all of one size. All have the
/// same 255 colours; what does not change from one picture to the next is left out.
std::string encode_gif(const std::vector<Image>& images, double seconds);

}  // namespace palpate::simulation
