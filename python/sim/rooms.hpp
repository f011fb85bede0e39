// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include "bindings/shared_model.hpp"
#include "palpate/evaluation/trial.hpp"

namespace palpate::python {

void bind_world(nanobind::module_& module);
void bind_pick(nanobind::module_& module);
void bind_evaluation(nanobind::module_& module);

/// What `palpate pick` can be configured with, from {"lift.height": 0.15}.
/// @throws BadInput for an option that there is not, or a value out of its range
evaluation::TrialOptions trial_options(const nanobind::dict& settings);

/// An object by its name or file, or an ObjectModel.
/// @throws BadInput for a name that is no object's
SharedModel object_from(nanobind::object object);

}  // namespace palpate::python
