// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palpate {

/// The folder of one run's results, which nobody else writes into while this object lives: an
/// advisory lock (flock) on the folder itself, which ends with the process however that ends.
class OutputFolder {
 public:
  /// Makes the folder and its parents, checks that files can be written into it, and locks it.
  /// @param results  names of the files that the run will write
  /// @param force    what is there of these is removed; else it is refused
  /// @throws BadInput, naming the folder, if it cannot be written, another process holds it, or
  ///         it holds one of the results and not `force`
  OutputFolder(std::filesystem::path path, const std::vector<std::string>& results, bool force);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  void lock();
  void clear(const std::vector<std::string>& results, bool force) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace palpate
