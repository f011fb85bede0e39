// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <string>
#include <utility>

#include "palpate/geometry/objects/object_model.hpp"

namespace palpate::python {

using SharedModel = std::shared_ptr<const geometry::ObjectModel>;

/// The model as C++ holds it; the Python object lives as long as the pointer.
inline SharedModel model_from(nanobind::object model) {
  const geometry::ObjectModel* held = nullptr;
  if (!nanobind::try_cast(model, held) || !held) {
    const std::string text = nanobind::repr(model).c_str();
    throw nanobind::type_error(
        ("model is " + text + ", not an ObjectModel, which ObjectModel(load_known_object(name)) is")
            .c_str());
  }
  return {held, [keep = std::make_shared<nanobind::object>(std::move(model))](const auto*) {
            const nanobind::gil_scoped_acquire acquire;
            keep->reset();
          }};
}

}  // namespace palpate::python
