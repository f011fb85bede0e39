// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// The evidence with the mesh's error as part of each contact's own: no contact can be compared
/// with the mesh more exactly than the mesh is like the object.
Evidence with_surface_error(Evidence evidence);

}  // namespace palpate::localization
