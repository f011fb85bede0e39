// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace palpate {

constexpr std::uint64_t kFnvOffset = 0xcbf29ce484222325ull;

/// FNV-1a, 64 bits (Fowler, Noll & Vo).
constexpr std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash = kFnvOffset) {
  constexpr std::uint64_t kPrime = 0x100000001b3ull;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * kPrime;
  return hash;
}

}  // namespace palpate
