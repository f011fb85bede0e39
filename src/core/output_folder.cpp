// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate {

namespace fs = std::filesystem;

OutputFolder::OutputFolder(fs::path path, const std::vector<std::string>& results, bool force)
    : path_(std::move(path)) {
  make_writable_folder(path_);
  lock();
  try {
    clear(results, force);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

OutputFolder::~OutputFolder() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputFolder::lock() {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) {
    throw BadInput(
        fmt::format("cannot open {}: {}", path_.string(), std::generic_category().message(errno)));
  }
  // Where a file system has no locks (ENOLCK, EOPNOTSUPP) the results go unguarded.
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(std::exchange(descriptor_, -1));
  throw BadInput(fmt::format("{} is in use: another run writes its results there", path_.string()));
}

void OutputFolder::clear(const std::vector<std::string>& results, bool force) const {
  std::error_code error;
  for (const auto& name : results) {
    if (force || !fs::exists(path_ / name, error)) continue;
    throw BadInput(fmt::format("{} is there already: --force overwrites it, another --out keeps it",
                               (path_ / name).string()));
  }
  for (const auto& name : results) {
    fs::remove(path_ / name, error);
    if (!error) continue;
    throw BadInput(fmt::format("cannot remove {}: {}", (path_ / name).string(), error.message()));
  }
}

}  // namespace palpate
