// SPDX-License-Identifier: Apache-2.0
#include "recording/seal.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

#include "palpate/core/durable_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/fnv1a.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {
namespace {

constexpr std::string_view kMagic = "PALPATE RECORDING ";
constexpr std::string_view kOpen = "unfinished\n";

/// FNV-1a, 64 bits, of all bytes after the seal. @throws BadInput if they cannot all be read
std::uint64_t checksum(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(kSealSize);
  std::uint64_t hash = kFnvOffset;
  std::array<char, 1 << 16> buffer;
  while (file) {
    file.read(buffer.data(), buffer.size());
    hash = fnv1a({buffer.data(), static_cast<std::size_t>(file.gcount())}, hash);
  }
  if (file.bad()) throw BadInput(fmt::format("{}: cannot be read", path.string()));
  return hash;
}

std::string closed_mark(const std::filesystem::path& path) {
  return fmt::format("finished {:016x}\n", checksum(path));
}

void write_seal(const std::filesystem::path& path, int version, std::string_view mark) {
  std::string seal = fmt::format("{}{}\n{}", kMagic, version, mark);
  seal.resize(kSealSize, '\0');
  DurableFile file(path, DurableFile::Mode::modify);
  file.sync();  // what is sealed, before the seal
  file.write(seal);
  file.close();
}

std::string read_seal(const std::filesystem::path& path) {
  std::error_code error;  // of a name too long for a file, for one
  if (!std::filesystem::exists(path, error)) {
    const auto partial = path.string() + ".partial";
    throw BadInput(std::filesystem::exists(partial, error)
                       ? fmt::format("{}: no such file; the recording was not finished, and what "
                                     "there is of it can be read as {}",
                                     path.string(), partial)
                       : fmt::format("{}: no such file", path.string()));
  }
  if (!std::filesystem::is_regular_file(path, error)) {
    throw BadInput(fmt::format("{}: not a file", path.string()));
  }
  std::string seal(kSealSize, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file) throw BadInput(fmt::format("{}: cannot be opened", path.string()));
  file.read(seal.data(), kSealSize);
  seal.resize(static_cast<std::size_t>(file.gcount()));
  return seal;
}

}  // namespace

void write_open_seal(const std::filesystem::path& path, int version) {
  write_seal(path, version, kOpen);
}

void write_closed_seal(const std::filesystem::path& path, int version) {
  write_seal(path, version, closed_mark(path));
}

Seal check_seal(const std::filesystem::path& path) {
  const std::string seal = read_seal(path);
  std::string_view rest = seal;
  if (!rest.starts_with(kMagic)) {
    throw BadInput(fmt::format("{}: not a palpate recording", path.string()));
  }
  rest.remove_prefix(kMagic.size());
  const std::string_view version = rest.substr(0, rest.find('\n'));
  Seal result;
  const auto [end, error] =
      std::from_chars(version.data(), version.data() + version.size(), result.version);
  if (error != std::errc{} || end != version.data() + version.size() ||
      result.version < kOldestFormatVersion || result.version > kFormatVersion) {
    throw BadInput(
        fmt::format("{}: recording format {:?} is none of {} to {}, which this program reads",
                    path.string(), version.substr(0, 20), kOldestFormatVersion, kFormatVersion));
  }
  rest.remove_prefix(std::min(rest.size(), version.size() + 1));
  if (rest.starts_with(kOpen)) return result;
  if (!rest.starts_with(closed_mark(path))) {
    throw BadInput(fmt::format("{}: damaged: its checksum does not match", path.string()));
  }
  result.finished = true;
  return result;
}

}  // namespace palpate::recording
