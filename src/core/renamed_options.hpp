// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// What an option of an earlier version is called now; the key itself where it kept its name.
/// @param key  with its sections, as in "locate.window"
std::string renamed_option(std::string_view key);

/// Why an option of an earlier version is gone, in one line; empty for any other key.
/// @param key  with its sections; a section with a dot at its end
std::string_view removed_option(std::string_view key);

}  // namespace palpate
