// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <optional>
#include <vector>

#include "libraries.hpp"
#include "palpate/localization/evidence.hpp"

namespace palpate::python {

/// Rows x, y, z, radius; none for None.
/// @throws BadInput for another shape
std::vector<localization::FreeSphere> spheres_from(nanobind::handle free_space);

/// What localize() and identify() take beside the object, as they name it.
struct EvidenceArguments {
  std::optional<localization::TableSupport> table;
  nanobind::handle free_space, planes;
  double false_contacts, noise_scale_prior, size_prior, surface_sigma;
};

/// @throws BadInput for free space and planes of another shape; other values are checked by the
/// search
localization::Evidence evidence_from(const Contacts& contacts, const EvidenceArguments& arguments);

}  // namespace palpate::python
