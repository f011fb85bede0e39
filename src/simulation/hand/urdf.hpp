// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace palpate::simulation {

/// A joint that follows another: angle = offset + ratio * leader. One that is locked follows any,
/// with the ratio 0.
struct MimicJoint {
  std::string joint, leader;
  double ratio = 1, offset = 0;  ///< offset in rad
};

/// A URDF as the simulator has to be given it. By itself it takes meshes whose files have the same
/// name in two folders for one, ignores mimics and limits of one bound, and renames joints.
struct Urdf {
  std::string text;
  std::vector<MimicJoint> mimics;             ///< of joints that move, in the order of the file
  std::map<std::string, std::string> meshes;  ///< files of meshes that the text names otherwise
};

/// Whether a file is a URDF, by its first element.
bool is_urdf(const std::filesystem::path& file);

/// @throws BadInput for what is not XML at all, a joint or link that is there twice, a mimic
/// without
///         finite numbers, links in a circle
Urdf read_urdf(const std::filesystem::path& file);

}  // namespace palpate::simulation
