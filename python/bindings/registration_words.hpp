// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>

#include "palpate/core/error.hpp"
#include "palpate/registration/registration.hpp"

namespace palpate::python {

inline registration::Primitive primitive_of(const std::string& name) {
  if (name == "point") return registration::Primitive::kPoint;
  if (name == "plane") return registration::Primitive::kPlane;
  throw BadInput(fmt::format("primitive '{}' is neither 'point' nor 'plane'", name));
}

}  // namespace palpate::python
