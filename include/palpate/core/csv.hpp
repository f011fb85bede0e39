// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

namespace palpate {

/// The text without blanks, tabs and carriage returns at its ends.
std::string_view trimmed(std::string_view text);

/// The text without the byte order mark that some programs write in front of it.
std::string_view without_byte_order_mark(std::string_view text);

/// Cells of a line of comma-separated values, trimmed; at least one. Quotes mean nothing.
std::vector<std::string_view> csv_cells(std::string_view line);

}  // namespace palpate
