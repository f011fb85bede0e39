// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/options.hpp"

namespace palpate {

/// Levenshtein distance: insertions, deletions and replacements that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The field's key that a user most likely meant; empty if there are no fields.
std::string nearest_key(std::string_view key, const std::vector<OptionField>& fields);

}  // namespace palpate
