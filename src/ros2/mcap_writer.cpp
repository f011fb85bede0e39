// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/mcap_writer.hpp"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "palpate/core/durable_file.hpp"
#include "palpate/core/version.hpp"
#include "ros2/compression.hpp"
#include "ros2/mcap_records.hpp"

namespace palpate::ros2 {
namespace {

struct ChannelEntry {
  std::string topic, type, record;
  std::uint32_t messages = 0;
};

struct SchemaEntry {
  std::string type, record;
};

/// Of the messages of a chunk or of the file.
struct TimeSpan {
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max(), last = 0;
  void add(std::uint64_t time) {
    first = std::min(first, time);
    last = std::max(last, time);
  }
  [[nodiscard]] bool empty() const { return first > last; }
  void put_to(McapFields& fields) const { fields.number(empty() ? 0 : first).number(last); }
};

}  // namespace

struct McapWriter::Impl {
  std::filesystem::path path, partial;
  DurableFile file;
  std::size_t chunk_size;
  std::uint64_t at = 0;  // bytes written
  Crc32 data_crc;
  std::vector<SchemaEntry> schemas;
  std::vector<ChannelEntry> channels;
  TimeSpan all, in_chunk;
  std::string chunk;  // its records
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index;  // of it
  std::string chunk_indexes, metadata_indexes;
  std::uint64_t messages = 0;
  std::uint32_t chunks = 0, metadatas = 0;

  Impl(std::filesystem::path named, std::size_t size)
      : path(std::move(named)),
        partial(path.string() + ".partial"),
        file(partial, DurableFile::Mode::replace),
        chunk_size(size) {}

  void append(std::string_view bytes) {
    file.write(bytes);
    data_crc.process_bytes(bytes.data(), bytes.size());
    at += bytes.size();
  }

  /// Into the chunk, or where there are none into the file.
  void add(const std::string& record) {
    if (chunk_size == 0) {
      append(record);
    } else {
      chunk += record;
    }
  }

  std::uint16_t schema_id(std::string_view type, std::string (*text)()) {
    const auto known = std::find_if(schemas.begin(), schemas.end(),
                                    [&](const SchemaEntry& entry) { return entry.type == type; });
    const auto id = static_cast<std::uint16_t>(known - schemas.begin() + 1);
    if (known != schemas.end()) return id;
    const std::string record =
        McapFields().number(id).text(type).text("ros2msg").text(text()).record(McapOp::schema);
    schemas.push_back({std::string(type), record});
    add(record);
    return id;
  }

  /// @return the bytes of the indexes, and where in the file those of each channel are
  McapFields write_message_indexes() {
    McapFields offsets;
    for (const auto& [channel, entries] : index) {
      McapFields pairs;
      for (const auto& [time, offset] : entries) pairs.number(time).number(offset);
      offsets.number(channel).number(at);
      append(McapFields().number(channel).text(pairs.bytes()).record(McapOp::message_index));
    }
    return offsets;
  }

  void end_chunk() {
    if (chunk.empty()) return;
    McapFields fields;
    in_chunk.put_to(fields);
    const std::string packed = compressed(chunk);
    fields.number(std::uint64_t{chunk.size()}).number(crc_of(chunk)).text(compression());
    fields.number(std::uint64_t{packed.size()}).raw(packed);
    const std::string record = fields.record(McapOp::chunk);
    const std::uint64_t start = at;
    append(record);
    const std::uint64_t indexes_start = at;
    const McapFields offsets = write_message_indexes();
    McapFields entry;
    in_chunk.put_to(entry);
    entry.number(start).number(std::uint64_t{record.size()}).text(offsets.bytes());
    entry.number(at - indexes_start).text(compression());
    entry.number(std::uint64_t{packed.size()}).number(std::uint64_t{chunk.size()});
    chunk_indexes += entry.record(McapOp::chunk_index);
    ++chunks;
    chunk.clear();
    index.clear();
    in_chunk = {};
  }

  std::string statistics() const {
    McapFields counts;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      counts.number(static_cast<std::uint16_t>(i)).number(std::uint64_t{channels[i].messages});
    }
    McapFields fields;
    fields.number(messages)
        .number(static_cast<std::uint16_t>(schemas.size()))
        .number(static_cast<std::uint32_t>(channels.size()))
        .number(std::uint32_t{0})
        .number(metadatas)
        .number(chunks);
    all.put_to(fields);
    return fields.text(counts.bytes()).record(McapOp::statistics);
  }

  /// Summary and footer, whose offsets are those of a file that is `at` bytes long.
  std::string ending() const {
    std::string schema_records, channel_records;
    for (const auto& entry : schemas) schema_records += entry.record;
    for (const auto& entry : channels) channel_records += entry.record;
    std::string summary, offsets;
    const auto add_group = [&](McapOp op, const std::string& records) {
      if (records.empty()) return;
      offsets += McapFields()
                     .number(static_cast<std::uint8_t>(op))
                     .number(at + summary.size())
                     .number(std::uint64_t{records.size()})
                     .record(McapOp::summary_offset);
      summary += records;
    };
    add_group(McapOp::schema, schema_records);
    add_group(McapOp::channel, channel_records);
    add_group(McapOp::statistics, statistics());
    add_group(McapOp::chunk_index, chunk_indexes);
    add_group(McapOp::metadata_index, metadata_indexes);
    McapFields footer;
    footer.number(at).number(at + summary.size()).number(std::uint32_t{0});
    std::string bytes = summary + offsets + footer.record(McapOp::footer);
    bytes.resize(bytes.size() - sizeof(std::uint32_t));  // the CRC covers all before it
    return McapFields().raw(bytes).number(crc_of(bytes)).bytes();
  }
};

McapWriter::McapWriter(std::filesystem::path path, std::size_t chunk_size)
    : impl_(new Impl(std::move(path), chunk_size)) {
  impl_->append(kMcapMagic);
  impl_->append(
      McapFields().text("ros2").text(fmt::format("palpate {}", version())).record(McapOp::header));
}

McapWriter::~McapWriter() = default;

std::uint64_t McapWriter::messages() const { return impl_->messages; }

std::uint16_t McapWriter::channel(const std::string& topic, std::string_view type,
                                  std::string (*schema)()) {
  auto& channels = impl_->channels;
  const auto known = std::find_if(channels.begin(), channels.end(),
                                  [&](const ChannelEntry& entry) { return entry.topic == topic; });
  const auto id = static_cast<std::uint16_t>(known - channels.begin());
  if (known != channels.end()) {
    if (known->type == type) return id;
    throw BadInput(fmt::format("topic {} has messages of {}, not of {}", topic, known->type, type));
  }
  const std::uint16_t schema_id = impl_->schema_id(type, schema);
  McapFields fields;
  fields.number(id).number(schema_id).text(topic).text("cdr").texts({});
  channels.push_back({topic, std::string(type), fields.record(McapOp::channel)});
  impl_->add(channels.back().record);
  return id;
}

void McapWriter::write(std::uint16_t channel, std::uint64_t time, std::string_view cdr) {
  const std::uint32_t sequence = impl_->channels[channel].messages++;
  McapFields fields;
  fields.number(channel).number(sequence).number(time).number(time).raw(cdr);
  if (impl_->chunk_size > 0) impl_->index[channel].emplace_back(time, impl_->chunk.size());
  impl_->add(fields.record(McapOp::message));
  impl_->in_chunk.add(time);
  impl_->all.add(time);
  ++impl_->messages;
  if (impl_->chunk_size > 0 && impl_->chunk.size() >= impl_->chunk_size) impl_->end_chunk();
}

void McapWriter::metadata(const std::string& name,
                          const std::map<std::string, std::string>& values) {
  impl_->end_chunk();
  const std::string record = McapFields().text(name).texts(values).record(McapOp::metadata);
  impl_->metadata_indexes += McapFields()
                                 .number(impl_->at)
                                 .number(std::uint64_t{record.size()})
                                 .text(name)
                                 .record(McapOp::metadata_index);
  impl_->append(record);
  ++impl_->metadatas;
}

void McapWriter::finish() {
  impl_->end_chunk();
  impl_->append(McapFields().number(impl_->data_crc.checksum()).record(McapOp::data_end));
  impl_->append(impl_->ending());
  impl_->append(kMcapMagic);
  impl_->file.close();
  publish_file(impl_->partial, impl_->path);
}

}  // namespace palpate::ros2
