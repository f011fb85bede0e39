// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string_view>

namespace palpate::simulation {

/// Calls a function with each tag of an XML text, without its brackets. Comments and text that is
/// quoted by CDATA are left out.
void for_each_tag(std::string_view text, const std::function<void(std::string_view)>& function);

/// Calls a function with the name and the value of each attribute of a tag.
void for_each_attribute(
    std::string_view tag,
    const std::function<void(std::string_view name, std::string_view value)>& function);

/// @throws BadInput for macros that are still to be expanded, numbers that are not finite (naming
///         line, element and attribute; limits may be infinite), and for more or more deeply nested
///         elements than any model has
void check_text(std::string_view text);

}  // namespace palpate::simulation
