// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "palpate/ros2/schema.hpp"

namespace palpate::ros2 {

/// Writes an MCAP file of the profile ros2: messages in CDR with their definitions, in chunks that
/// are compressed (zstd) where the build can, a CRC of every chunk, of the data and of the summary,
/// and an index.
///
/// It works on PATH.partial, which finish() renames to PATH. See https://mcap.dev/spec.
class McapWriter {
 public:
  /// @param chunk_size  bytes of messages after which a chunk ends; 0: the file has no chunks
  /// @throws BadInput if the file cannot be written
  explicit McapWriter(std::filesystem::path path, std::size_t chunk_size = 1 << 20);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// @param time  ns
  /// @throws BadInput if it cannot be written, or the topic has messages of another type
  template <Message M>
  void write(const std::string& topic, std::uint64_t time, const M& message) {
    write(channel(topic, M::kType, &message_schema<M>), time, serialize(message));
  }

  /// Texts that hold for the whole file.
  void metadata(const std::string& name, const std::map<std::string, std::string>& values);

  std::uint64_t messages() const;  ///< written so far

  /// Writes the summary, and gives the file its name. Nothing may be written afterwards.
  void finish();

 private:
  std::uint16_t channel(const std::string& topic, std::string_view type, std::string (*schema)());
  void write(std::uint16_t channel, std::uint64_t time, std::string_view cdr);

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::ros2
