// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// A grid of cubes, in each of which the object may be or is known not to be.
struct FreeVoxels {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();  ///< cubes along each axis
  std::vector<char> free;                          ///< not 0: free of the object; z fastest, then y
  double pitch = 0;                                ///< of a cube, m
  /// Its axes along the indices, its origin the outer corner of voxel 0, 0, 0.
  Eigen::Isometry3d T_frame_grid = Eigen::Isometry3d::Identity();
};

/// Balls in the free voxels, the smallest first. Voxels are joined to cubes of 2, 4, 8.. as far as
/// all of one are free, each of which gives the ball inside it; so a ball never says more than the
/// voxels do, and the corners are left out.
/// @throws BadInput for another number of voxels than the size says, and a pitch that is not
///         positive and finite
std::vector<FreeSphere> free_spheres_of(const FreeVoxels& voxels);

/// Free space of a CSV: balls, with the columns x,y,z,radius (m), or the free voxels of a grid
/// along the axes, with their centers x,y,z and their pitch, size (m), as free_spheres_of() takes
/// them.
/// @throws BadInput for a missing column, a value that is not finite, a negative radius, and
///         voxels that are not of one grid, or of one too large
std::vector<FreeSphere> read_free_space(const std::filesystem::path& path);

}  // namespace palpate::localization
