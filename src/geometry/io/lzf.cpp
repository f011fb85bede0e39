// SPDX-License-Identifier: Apache-2.0
#include "geometry/io/lzf.hpp"

namespace palpate::geometry {
namespace {

std::size_t byte_at(std::string_view stream, std::size_t at) {
  return static_cast<unsigned char>(stream[at]);
}

}  // namespace

std::optional<std::string> lzf_decompress(std::string_view stream, std::size_t size) {
  std::string result;
  std::size_t at = 0;
  while (at < stream.size()) {
    const std::size_t control = byte_at(stream, at++);
    if (control < 32) {  // so many bytes, and one more, as they stand
      if (at + control + 1 > stream.size()) return std::nullopt;
      result += stream.substr(at, control + 1);
      at += control + 1;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (at >= stream.size()) return std::nullopt;
      length += byte_at(stream, at++);
    }
    if (at >= stream.size()) return std::nullopt;
    const std::size_t back = ((control & 31) << 8) + byte_at(stream, at++) + 1;
    if (back > result.size() || result.size() + length + 2 > size) return std::nullopt;
    for (std::size_t k = 0; k < length + 2; ++k) result += result[result.size() - back];
  }
  if (result.size() != size) return std::nullopt;
  return result;
}

}  // namespace palpate::geometry
