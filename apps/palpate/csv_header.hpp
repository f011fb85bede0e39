// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace palpate::app {

/// First line of a text that is not blank, without blanks at its ends: the header, if it is a CSV.
std::string_view csv_header(std::string_view text);

}  // namespace palpate::app
