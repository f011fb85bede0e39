// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/core/random.hpp"

namespace palpate::fuzz {

/// The bytes, changed in one to four places: a number replaced, a token repeated, moved or dropped,
/// a byte or a little-endian word overwritten, the end cut off.
std::string mutated(std::string bytes, RandomStream& random);

}  // namespace palpate::fuzz
