// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "palpate/recording/recording.hpp"
#include "palpate/ros2/reading_stream.hpp"

namespace palpate::ros2 {

/// What a file of messages holds of a hand.
struct Bag {
  std::vector<hand::HandReading> readings;  ///< one a tick; time from the first one; where the
                                            ///< clock was set back, those after it
  std::vector<recording::Event> events;     ///< of files that export_mcap() wrote
  StreamCounts counts;
  std::uint64_t messages = 0;  ///< in the file, of all topics
  bool complete = true;        ///< false: the file's end is missing
};

/// Metadata of an MCAP file that export_mcap() wrote; empty for others.
/// @throws BadInput as read_mcap()
std::map<std::string, std::string> bag_metadata(const std::filesystem::path& path);

/// Whether it is a folder, as `ros2 bag record` writes, or a file that begins as bags do, those of
/// ROS 1 and of SQLite among them.
bool is_bag(const std::filesystem::path& path);

/// The MCAP files of a bag in the order of their numbers: itself, or those in its folder.
/// @throws BadInput for a bag of another kind, with what converts it
std::vector<std::filesystem::path> bag_files(const std::filesystem::path& path);

/// The readings of a hand from a bag of anyone's, an MCAP file or a folder of them: joint states,
/// contacts of the fingers, and where the mount is.
/// @throws BadInput, naming the file, the topics that it has and what is missing, for one without
///         any reading; and as read_mcap() and bag_files()
Bag read_bag(const std::filesystem::path& path, const hand::Description& hand,
             const RobotInterface& interface = {}, const StreamOptions& options = {});

}  // namespace palpate::ros2
