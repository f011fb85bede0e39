// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "palpate/recording/recording.hpp"
#include "palpate/ros2/robot_interface.hpp"

namespace palpate::ros2 {

/// Name of the metadata of an exported file: object (empty for one from a mesh file), hand, seed,
/// program_version, config_toml.
inline constexpr const char* kMetadata = "palpate";

/// Writes a recording as an MCAP file of ROS 2: what the hand reported, as messages_of() has it,
/// and below RobotInterface::palpate the estimates (estimate, modes, mode_weights, status,
/// markers), the object's mesh (object) and the events (events). Of the truth the file holds
/// nothing.
/// @param chunk_size  as McapWriter has it
/// @return messages written
/// @throws BadInput if the file cannot be written
std::uint64_t export_mcap(const recording::Recording& recording, const std::filesystem::path& path,
                          const RobotInterface& interface = {}, std::size_t chunk_size = 1 << 20);

}  // namespace palpate::ros2
