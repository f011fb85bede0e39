// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace palpate {

/// A file open for writing, of which every call is checked.
///
/// Every function throws BadInput "cannot write PATH: REASON", the reason in the words of the
/// operating system ("No space left on device"), if it does not do all that it says.
class DurableFile {
 public:
  enum class Mode {
    replace,  ///< empty, made if it is missing
    append,   ///< what is there stays, made if it is missing
    modify,   ///< what is there stays, must exist
  };

  DurableFile(std::filesystem::path path, Mode mode);
  ~DurableFile();
  DurableFile(const DurableFile&) = delete;
  DurableFile& operator=(const DurableFile&) = delete;

  /// Writes all of the bytes where the last write ended (append: at the end).
  void write(std::string_view bytes);

  /// Cuts the file off after so many bytes.
  void truncate(std::uint64_t size);

  /// Returns when all that was written is on the disk.
  void sync();

  /// Nothing may be written afterwards. A file that is destroyed without it was not written.
  void close();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// Gives a closed file its final name, in place of what bears it: first its bytes reach the disk,
/// then the name does. What is seen under the final name is then whole, after a loss of power too.
/// @throws BadInput, with the reason, if that fails; `path` is then whole all the same: what it was
///         before or, where only the name is not known to be on the disk, the new file
void publish_file(const std::filesystem::path& partial, const std::filesystem::path& path);

/// Appends to a file and returns when the bytes are on the disk.
/// @throws BadInput, with the reason, if not; the file then ends with any part of the bytes
void append_durably(const std::filesystem::path& path, std::string_view bytes);

}  // namespace palpate
