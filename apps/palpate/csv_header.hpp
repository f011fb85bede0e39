// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace palpate::app {

/// Text without the byte order mark that some programs write in front of it.
std::string_view without_byte_order_mark(std::string_view text);

/// First line of a text that is not blank, without blanks at its ends: the header, if it is a CSV.
std::string_view csv_header(std::string_view text);

}  // namespace palpate::app
