// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace palpate::geometry {

/// Bytes of an LZF stream (Lehmann's format, as in compressed PCD files).
/// @param size  of the result; nothing if the stream gives another number or refers outside
std::optional<std::string> lzf_decompress(std::string_view stream, std::size_t size);

}  // namespace palpate::geometry
