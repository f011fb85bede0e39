// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// @throws BadInput naming the first value that cannot be used
void check_evidence(const geometry::ObjectModel& model, const Evidence& evidence);

}  // namespace palpate::localization
