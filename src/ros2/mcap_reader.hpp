// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace palpate::ros2 {

inline constexpr std::uint64_t kMaxMcapRecord = std::uint64_t{256} << 20;  ///< bytes that are read

/// A message as it lies in an MCAP file; what it refers to lives as long as the call that gives it.
struct McapMessage {
  std::string_view topic;
  std::string_view type;      ///< as "sensor_msgs/msg/JointState"
  std::string_view encoding;  ///< "cdr" in files of ROS 2
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0, publish_time = 0;  ///< ns
  std::string_view data;
};

struct McapContents {
  std::uint64_t messages = 0;
  bool complete = true;  ///< false: whoever wrote it stopped before the end; all before was read
  std::map<std::string, std::map<std::string, std::string>> metadata;  ///< by name
};

/// Reads an MCAP file from its beginning to its end, chunk by chunk, in the order in which it was
/// written. Every CRC that is there is checked; the index is not used, attachments are skipped.
///
/// Memory is at most twice kMaxMcapRecord and a few hundred bytes a channel, whatever the file
/// states.
/// @throws BadInput, with the path and the byte, for a file that is missing, is no MCAP, has chunks
///         of another compression than zstd and lz4 (or these in a build without them), or is
///         damaged elsewhere than by a missing end; what the callback throws goes on
McapContents read_mcap(const std::filesystem::path& path,
                       const std::function<void(const McapMessage&)>& on_message);

}  // namespace palpate::ros2
