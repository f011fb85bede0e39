// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/durable_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

int flags_of(DurableFile::Mode mode) {
  switch (mode) {
    case DurableFile::Mode::replace:
      return O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
    case DurableFile::Mode::append:
      return O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC;
    case DurableFile::Mode::modify:
      return O_WRONLY | O_CLOEXEC;
  }
  return O_WRONLY;
}

[[noreturn]] void cannot_write(const fs::path& path, int reason) {
  throw BadInput(
      fmt::format("cannot write {}: {}", path.string(), std::generic_category().message(reason)));
}

/// @throws BadInput for a device or a pipe, whose place a file must not take
void require_replaceable(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  // What is wrong with a folder the system says itself.
  if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status)) return;
  throw BadInput(fmt::format("cannot write {}: it is no file", path.string()));
}

/// Makes the names in a folder durable, where its file system can (else EINVAL).
void sync_folder(const fs::path& folder) {
  const fs::path path = folder.empty() ? fs::path(".") : folder;
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // a folder that may be written but not read
  const int failed = ::fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno;
  ::close(descriptor);
  if (failed != 0) cannot_write(folder, failed);
}

}  // namespace

DurableFile::DurableFile(fs::path path, Mode mode)
    : path_(std::move(path)), descriptor_(::open(path_.c_str(), flags_of(mode), 0666)) {
  if (descriptor_ < 0) fail();
}

DurableFile::~DurableFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void DurableFile::fail() const { cannot_write(path_, errno); }

void DurableFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void DurableFile::truncate(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) fail();
}

void DurableFile::sync() {
  // Devices and pipes have nothing to sync (EINVAL).
  if (::fsync(descriptor_) != 0 && errno != EINVAL) fail();
}

void DurableFile::close() {
  // Not tried again: the descriptor is gone even if it fails (close(2)).
  if (::close(std::exchange(descriptor_, -1)) != 0) fail();
}

void publish_file(const fs::path& partial, const fs::path& path) {
  require_replaceable(path);
  DurableFile file(partial, DurableFile::Mode::modify);
  file.sync();
  file.close();
  if (std::rename(partial.c_str(), path.c_str()) != 0) cannot_write(path, errno);
  sync_folder(path.parent_path());
}

void append_durably(const fs::path& path, std::string_view bytes) {
  DurableFile file(path, DurableFile::Mode::append);
  file.write(bytes);
  file.sync();
  file.close();
}

}  // namespace palpate
