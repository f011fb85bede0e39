// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <string_view>

namespace palpate::geometry {

/// The value stored in the first sizeof(T) bytes, which are there, in the given byte order.
template <typename T>
T read_value(std::string_view bytes, std::endian order = std::endian::little) {
  std::array<char, sizeof(T)> raw;
  std::copy_n(bytes.begin(), sizeof(T), raw.begin());
  if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

/// Appends the value's bytes, the lowest first.
template <typename T>
void append_value(std::string& bytes, T value) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (std::endian::native != std::endian::little) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

}  // namespace palpate::geometry
