// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate::ros2 {

/// Name, in MCAP files, of the compression that compressed() makes; empty: this build has none.
std::string_view compression();

/// The bytes compressed as compression() says; without it, as they are.
std::string compressed(std::string_view bytes);

/// The bytes before they were compressed: "zstd", "lz4" (its frame format) or "".
/// @param size  that they have then
/// @throws BadInput for another compression, or one that this build lacks, for bytes that are
///         damaged, and for another size
std::string decompressed(std::string_view bytes, std::string_view compression, std::uint64_t size);

}  // namespace palpate::ros2
