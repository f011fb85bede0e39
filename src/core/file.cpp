// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/file.hpp"

#include <fmt/format.h>

#include <cerrno>
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

/// What a link leads to, so that the link stays; the path where it is none or leads nowhere.
fs::path behind_link(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::canonical(path, error);
  return error ? path : target;
}

/// @throws BadInput unless it is there and no folder
void require_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    throw BadInput(fmt::format("{} does not exist", path.string()));
  }
  if (error) throw BadInput(fmt::format("cannot read {}: {}", path.string(), error.message()));
  if (fs::is_directory(status)) throw BadInput(fmt::format("{} is a folder", path.string()));
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  make_parents(path);
  const fs::path target = behind_link(path), temporary = partial(target);
  try {
    DurableFile file(temporary, DurableFile::Mode::replace);
    file.write(bytes);
    file.close();
    publish_file(temporary, target);
  } catch (const BadInput&) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

std::string read_file(const fs::path& path) {
  require_file(path);
  std::ifstream in(path, std::ios::binary);
  if (!in.is_open()) {
    throw BadInput(
        fmt::format("cannot read {}: {}", path.string(), std::generic_category().message(errno)));
  }
  std::string content;
  std::vector<char> chunk(1 << 16);
  while (in.read(chunk.data(), std::ssize(chunk)) || in.gcount() > 0) {
    content.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
    if (content.size() > kMaxBytes) {  // as a device never ends
      throw BadInput(fmt::format("{} has more than {} bytes", path.string(), kMaxBytes));
    }
  }
  // One that fails midway does not get to its end.
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
