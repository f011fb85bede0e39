// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/cache.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

using Word = unsigned __int128;

constexpr Word wide(std::uint64_t high, std::uint64_t low) { return Word{high} << 64 | low; }

constexpr Word kOffset = wide(0x6c62272e07bb0142ull, 0x62b821756295c58dull);
constexpr Word kPrime = wide(0x0000000001000000ull, 0x000000000000013bull);

fs::path folder_of(const char* variable) {
  const char* value = std::getenv(variable);
  return value ? value : "";
}

/// First line of an entry. It covers the key too, so that an entry never answers for another key.
std::string seal(std::string_view key, std::string_view bytes) {
  std::string all = fmt::format("{}:{}", key.size(), key);
  all += bytes;
  return "palpate-cache 1 " + content_hash(all) + "\n";
}

}  // namespace

fs::path cache_folder() {
  if (const fs::path chosen = folder_of("PALPATE_CACHE"); !chosen.empty()) return chosen;
  // The XDG specification asks to ignore relative paths.
  if (const fs::path xdg = folder_of("XDG_CACHE_HOME"); xdg.is_absolute()) return xdg / "palpate";
  if (const fs::path home = folder_of("HOME"); home.is_absolute()) {
    return home / ".cache" / "palpate";
  }
  return {};
}

std::string content_hash(std::string_view bytes) {
  Word hash = kOffset;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * kPrime;
  return fmt::format("{:016x}{:016x}", static_cast<std::uint64_t>(hash >> 64),
                     static_cast<std::uint64_t>(hash));
}

std::optional<std::string> read_cache(std::string_view key) {
  const fs::path folder = cache_folder();
  if (folder.empty()) return std::nullopt;
  try {
    const std::string entry = read_file(folder / content_hash(key));
    const std::size_t start = entry.find('\n') + 1;
    const std::string_view bytes = std::string_view(entry).substr(start);
    if (entry.substr(0, start) != seal(key, bytes)) return std::nullopt;
    return std::string(bytes);
  } catch (const BadInput&) {
    return std::nullopt;
  }
}

void write_cache(std::string_view key, std::string_view bytes) {
  const fs::path folder = cache_folder();
  if (folder.empty()) return;
  try {
    // Two processes that write one entry at once may damage it; its seal makes that a miss.
    write_file_atomically(folder / content_hash(key), seal(key, bytes).append(bytes));
  } catch (const BadInput&) {
    // Without a place to write there is no cache, and nothing that depends on one.
  }
}

}  // namespace palpate
