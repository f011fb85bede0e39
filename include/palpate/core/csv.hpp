// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

namespace palpate {

/// The text without blanks, tabs and carriage returns at its ends.
std::string_view trimmed(std::string_view text);

/// Cells of a line of comma-separated values, trimmed; at least one. Quotes mean nothing.
std::vector<std::string_view> csv_cells(std::string_view line);

}  // namespace palpate
