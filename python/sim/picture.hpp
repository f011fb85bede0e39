// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <array>
#include <cstdint>

#include "palpate/simulation/rendering/image.hpp"

namespace palpate::python {

/// A picture as an array of its own, (height, width, 3), uint8.
inline nanobind::object array_of(const simulation::Image& image) {
  namespace nb = nanobind;
  const std::array<std::size_t, 3> shape = {static_cast<std::size_t>(image.height),
                                            static_cast<std::size_t>(image.width), 3};
  return nb::cast(nb::ndarray<nb::numpy, const std::uint8_t>(image.rgb.data(), 3, shape.data(), {}),
                  nb::rv_policy::copy);
}

}  // namespace palpate::python
