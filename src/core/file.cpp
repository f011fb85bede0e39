// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <vector>

#include "palpate/core/durable_file.hpp"
#include "palpate/core/error.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;

fs::path partial(const fs::path& path) { return path.string() + ".partial"; }

void make_parents(const fs::path& path) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) {
    throw BadInput(
        fmt::format("cannot make the folder {}: {}", path.parent_path().string(), error.message()));
  }
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  make_parents(path);
  const fs::path temporary = partial(path);
  try {
    DurableFile file(temporary, DurableFile::Mode::replace);
    file.write(bytes);
    file.close();
    publish_file(temporary, path);
  } catch (const BadInput&) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

std::string read_file(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw BadInput(fmt::format("{} does not exist", path.string()));
  if (fs::is_directory(path, error)) throw BadInput(fmt::format("{} is a folder", path.string()));
  std::ifstream in(path, std::ios::binary);
  std::string content;
  std::vector<char> chunk(1 << 16);
  while (in.read(chunk.data(), std::ssize(chunk)) || in.gcount() > 0) {
    content.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
    if (content.size() > kMaxBytes) {  // as a device never ends
      throw BadInput(fmt::format("{} has more than {} bytes", path.string(), kMaxBytes));
    }
  }
  // Neither a file that does not open nor one that fails midway gets to its end.
  if (!in.eof() || in.bad()) throw BadInput(fmt::format("cannot read {}", path.string()));
  return content;
}

void make_writable_folder(const fs::path& path) {
  const fs::path probe = path / ".palpate-write-probe";
  write_file_atomically(probe, "");
  std::error_code ignored;
  fs::remove(probe, ignored);
}

}  // namespace palpate
