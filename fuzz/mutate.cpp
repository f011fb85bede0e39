// SPDX-License-Identifier: Apache-2.0
#include "mutate.hpp"

#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>

#include "grammar.hpp"

namespace palpate::fuzz {
namespace {

bool in_token(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_';
}

/// Begin and length of the token at or around a place.
std::pair<std::size_t, std::size_t> token_at(const std::string& bytes, std::size_t place) {
  std::size_t begin = place, end = place;
  while (begin > 0 && in_token(bytes[begin - 1])) --begin;
  while (end < bytes.size() && in_token(bytes[end])) ++end;
  return {begin, end - begin};
}

void overwrite_word(std::string& bytes, RandomStream& random) {
  constexpr std::array<std::uint64_t, 8> kWords = {
      0, 1, 0x7fffffff, 0xffffffff, 0x7ff8000000000000, 0x7fefffffffffffff, 1ull << 62, ~0ull};
  const std::uint64_t word = kWords[random.index(kWords.size())];
  const std::size_t size = std::min<std::size_t>(std::size_t{1} << random.index(4), bytes.size());
  std::memcpy(&bytes[random.index(bytes.size() - size + 1)], &word, size);
}

void change(std::string& bytes, RandomStream& random) {
  const auto [begin, length] = token_at(bytes, random.index(bytes.size()));
  const std::string token = bytes.substr(begin, length);
  switch (random.index(7)) {
    case 0:
      bytes.replace(begin, length, hostile_real(random));
      break;
    case 1:
      bytes.replace(begin, length, hostile_integer(random));
      break;
    case 2:
      bytes.insert(begin, token + " ");
      break;
    case 3:
      bytes.erase(begin, length + 1);
      break;
    case 4:
      bytes[random.index(bytes.size())] = static_cast<char>(random.index(256));
      break;
    case 5:
      overwrite_word(bytes, random);
      break;
    default:
      bytes.resize(random.index(bytes.size() + 1));
  }
}

}  // namespace

std::string mutated(std::string bytes, RandomStream& random) {
  for (std::size_t i = 1 + random.index(4); i > 0 && !bytes.empty(); --i) change(bytes, random);
  return bytes;
}

}  // namespace palpate::fuzz
