// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/crc.hpp>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

namespace palpate::ros2 {

inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

enum class McapOp : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  attachment,
  attachment_index,
  statistics,
  metadata,
  metadata_index,
  summary_offset,
  data_end
};

inline constexpr std::size_t kMcapPrefix = 9;  ///< bytes of a record's opcode and length

using Crc32 = boost::crc_32_type;

inline std::uint32_t crc_of(std::string_view bytes) {
  Crc32 crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

/// The fields of a record, little endian.
class McapFields {
 public:
  template <class T>
  McapFields& number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    return *this;
  }
  /// With its length in 32 bits before it.
  McapFields& text(std::string_view value) {
    return number(static_cast<std::uint32_t>(value.size())).raw(value);
  }
  McapFields& raw(std::string_view value) {
    bytes_ += value;
    return *this;
  }
  McapFields& texts(const std::map<std::string, std::string>& values) {
    McapFields pairs;
    for (const auto& [key, value] : values) pairs.text(key).text(value);
    return text(pairs.bytes_);
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

  /// The whole record: opcode, length, fields.
  [[nodiscard]] std::string record(McapOp op) const {
    McapFields whole;
    whole.number(static_cast<std::uint8_t>(op)).number(std::uint64_t{bytes_.size()}).raw(bytes_);
    return whole.bytes_;
  }

 private:
  std::string bytes_;
};

}  // namespace palpate::ros2
