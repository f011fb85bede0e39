// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/version.hpp"

namespace palpate {

std::string_view version() { return PALPATE_VERSION; }

}  // namespace palpate
