// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "bindings/shared_model.hpp"
#include "palpate/core/options.hpp"
#include "palpate/evaluation/trial.hpp"

namespace palpate::python {

void bind_world(nanobind::module_& module);
void bind_pick(nanobind::module_& module);
void bind_evaluation(nanobind::module_& module);
void bind_relocate(nanobind::module_& module);
void bind_plan(nanobind::module_& module);

/// Sets options from {"lift.height": 0.15}.
/// @throws BadInput for an option that there is not, or a value out of its range
template <class Options>
void apply_settings(const nanobind::dict& settings, Options& options) {
  for (const auto& [key, value] : settings) {
    if (!nanobind::isinstance<nanobind::str>(key)) {
      throw nanobind::type_error("options are named by strings, as {'lift.height': 0.15}");
    }
    nanobind::str text = nanobind::str(value);
    if (nanobind::isinstance<nanobind::bool_>(value)) {
      text = nanobind::str(nanobind::cast<bool>(value) ? "true" : "false");
    }
    apply_setting(std::string(nanobind::cast<const char*>(key)) + "=" + text.c_str(), options);
  }
}

/// What `palpate pick` can be configured with, from {"lift.height": 0.15}.
/// @throws BadInput for an option that there is not, or a value out of its range
evaluation::TrialOptions trial_options(const nanobind::dict& settings);

/// An object by its name or file, or an ObjectModel.
/// @throws BadInput for a name that is no object's
SharedModel object_from(nanobind::object object);

}  // namespace palpate::python
