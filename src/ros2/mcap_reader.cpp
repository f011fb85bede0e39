// SPDX-License-Identifier: Apache-2.0
#include "ros2/mcap_reader.hpp"

#include <fmt/format.h>

#include <fstream>

#include "palpate/core/error.hpp"
#include "ros2/compression.hpp"
#include "ros2/mcap_records.hpp"

namespace palpate::ros2 {
namespace {

/// Fields of a record, in the order of its definition.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : rest_(bytes) {}

  std::string_view raw(std::uint64_t size) {
    if (size > rest_.size()) {
      throw BadInput(fmt::format("{} bytes are needed where {} are left", size, rest_.size()));
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  template <class T>
  T number() {
    T value;
    std::memcpy(&value, raw(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view text() { return raw(number<std::uint32_t>()); }
  std::map<std::string, std::string> texts() {
    FieldReader pairs(text());
    std::map<std::string, std::string> values;
    while (!pairs.rest_.empty()) {
      const std::string key(pairs.text());
      values[key] = pairs.text();
    }
    return values;
  }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

struct KnownChannel {
  std::string topic, type, encoding;
};

/// What the records of the data section state, wherever they stand.
class Contents {
 public:
  explicit Contents(const std::function<void(const McapMessage&)>& on_message)
      : on_message_(on_message) {}

  void take(McapOp op, std::string_view bytes) {
    FieldReader fields(bytes);
    if (op == McapOp::schema) {
      take_schema(fields);
    } else if (op == McapOp::channel) {
      take_channel(fields);
    } else if (op == McapOp::message) {
      take_message(fields);
    } else if (op == McapOp::metadata) {
      const std::string name(fields.text());
      contents.metadata[name] = fields.texts();
    } else if (op == McapOp::chunk) {
      take_chunk(fields);
    }
  }

  McapContents contents;

 private:
  void take_schema(FieldReader& fields) {
    const auto id = fields.number<std::uint16_t>();
    types_[id] = fields.text();
  }

  void take_channel(FieldReader& fields) {
    const auto id = fields.number<std::uint16_t>();
    const auto type = types_.find(fields.number<std::uint16_t>());
    const std::string topic(fields.text());
    channels_[id] = {topic, type == types_.end() ? "" : type->second, std::string(fields.text())};
  }

  void take_message(FieldReader& fields) {
    const auto id = fields.number<std::uint16_t>();
    const auto channel = channels_.find(id);
    if (channel == channels_.end()) {
      throw BadInput(fmt::format("a message of channel {}, which there is not", id));
    }
    const auto sequence = fields.number<std::uint32_t>();
    const auto log_time = fields.number<std::uint64_t>();
    const auto publish_time = fields.number<std::uint64_t>();
    ++contents.messages;
    on_message_({channel->second.topic, channel->second.type, channel->second.encoding, sequence,
                 log_time, publish_time, fields.rest()});
  }

  void take_chunk(FieldReader& fields) {
    fields.raw(2 * sizeof(std::uint64_t));  // its times
    const auto size = fields.number<std::uint64_t>();
    const auto crc = fields.number<std::uint32_t>();
    const std::string_view compression = fields.text();
    if (size > kMaxMcapRecord) {
      throw BadInput(fmt::format("a chunk of {} bytes, at most {} are read", size, kMaxMcapRecord));
    }
    const std::string records =
        decompressed(fields.raw(fields.number<std::uint64_t>()), compression, size);
    if (crc != 0 && crc != crc_of(records)) {
      throw BadInput(fmt::format("a chunk of {} bytes whose CRC differs", size));
    }
    FieldReader rest(records);
    while (!rest.rest().empty()) {
      const auto op = static_cast<McapOp>(rest.number<std::uint8_t>());
      const std::string_view record = rest.raw(rest.number<std::uint64_t>());
      if (op == McapOp::chunk) throw BadInput("a chunk in a chunk");
      if (op == McapOp::metadata) throw BadInput("metadata in a chunk");  // which is all kept
      take(op, record);
    }
  }

  const std::function<void(const McapMessage&)>& on_message_;
  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, KnownChannel> channels_;
};

bool is_needed(McapOp op) {
  return op == McapOp::schema || op == McapOp::channel || op == McapOp::message ||
         op == McapOp::metadata || op == McapOp::chunk;
}

/// A file read forwards, of which as much is there as there is.
class Source {
 public:
  explicit Source(const std::filesystem::path& path) : in_(path, std::ios::binary) {
    std::error_code error;
    size_ = std::filesystem::file_size(path, error);
    if (error || !in_) throw BadInput("cannot be read");
  }
  [[nodiscard]] std::uint64_t at() const { return at_; }
  [[nodiscard]] std::uint64_t left() const { return size_ - at_; }

  std::string_view read(std::uint64_t size) {
    buffer_.resize(size);
    in_.read(buffer_.data(), static_cast<std::streamsize>(size));
    if (!in_) throw BadInput("cannot be read");
    at_ += size;
    return buffer_;
  }
  void skip(std::uint64_t size) {
    in_.seekg(static_cast<std::streamoff>(size), std::ios::cur);
    at_ += size;
  }

 private:
  std::ifstream in_;
  std::uint64_t size_ = 0, at_ = 0;
  std::string buffer_;
};

/// @return false at the end of the data
bool read_record(Source& source, Contents& contents) {
  if (source.left() < kMcapPrefix) return contents.contents.complete = false;
  FieldReader prefix(source.read(kMcapPrefix));
  const auto op = static_cast<McapOp>(prefix.number<std::uint8_t>());
  const auto size = prefix.number<std::uint64_t>();
  if (op == McapOp::data_end || op == McapOp::footer) return false;
  if (size > source.left()) return contents.contents.complete = false;
  if (!is_needed(op)) {
    source.skip(size);
  } else if (size > kMaxMcapRecord) {
    throw BadInput(fmt::format("a record of {} bytes, at most {} are read", size, kMaxMcapRecord));
  } else {
    contents.take(op, source.read(size));
  }
  return true;
}

McapContents read_all(const std::filesystem::path& path,
                      const std::function<void(const McapMessage&)>& on_message) {
  std::uint64_t record = 0;
  bool in_callback = false;
  const std::function<void(const McapMessage&)> guarded = [&](const McapMessage& message) {
    in_callback = true;
    on_message(message);
    in_callback = false;
  };
  try {
    Source source(path);
    if (source.left() < kMcapMagic.size() || source.read(kMcapMagic.size()) != kMcapMagic) {
      throw BadInput("no MCAP");
    }
    Contents contents(guarded);
    do record = source.at();
    while (read_record(source, contents));
    return contents.contents;
  } catch (const BadInput& error) {
    if (in_callback) throw;
    throw BadInput(fmt::format("{}: record at byte {}: {}", path.string(), record, error.what()));
  }
}

}  // namespace

McapContents read_mcap(const std::filesystem::path& path,
                       const std::function<void(const McapMessage&)>& on_message) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw BadInput(fmt::format("{} is no file", path.string()));
  }
  return read_all(path, on_message);
}

}  // namespace palpate::ros2
