// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace palpate {

inline constexpr std::uint64_t kFnvOffset = 0xcbf29ce484222325;  ///< hash of no bytes

/// FNV-1a, 64 bits (Fowler, Noll, Vo): of some bytes after those of another hash.
constexpr std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash = kFnvOffset) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

}  // namespace palpate
