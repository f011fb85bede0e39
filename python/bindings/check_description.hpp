// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/description.hpp"

namespace palpate::python {

/// @throws BadInput for an index that names nothing, postures of another hand, and a hand that is
///         too large
void check_description(const hand::Description& hand);

}  // namespace palpate::python
