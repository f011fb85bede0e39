// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::tactile {

/// Indentation of a gel (GelSight, DIGIT), as its photometric stereo or its vendor's driver gives
/// it. The sensor's frame lies in the undeformed surface: x along the columns, y along the rows, z
/// out of the gel; the middle of the map is its origin.
struct HeightMap {
  Eigen::MatrixXd depth;  ///< m by which the gel is pushed in, rows x columns; 0: undeformed
  double pixel = 0;       ///< m, side of a pixel on the gel
};

struct HeightMapOptions {
  double min_depth = 0.0001;     ///< m above which the gel touches the object
  int cell = 16;                 ///< pixels, side of the squares that give one contact each
  double min_share = 0.5;        ///< of a square's pixels that must touch
  double depth_sigma = 0.00005;  ///< m, error of a square's mean depth
  double slope_sigma = 0.1;      ///< rad, error of a square's slope besides that of its depths
};

/// One contact for each square of the map that touches: the mean point, and the normal of the plane
/// that fits the depths best. The object lies beyond the gel, so its surface there is z = -depth
/// and its outward normal -(d depth/dx, d depth/dy, 1), normalised.
///
/// @param T_frame_sensor  of the sensor in the frame of the contacts
/// @return contacts without forces, in the order of rows and columns; none where nothing touches
/// @throws BadInput for a map that is empty, not finite or deeper than it is long, a pixel that is
///         not positive, or options out of range
std::vector<Contact> contacts_of_height_map(const HeightMap& map,
                                            const Eigen::Isometry3d& T_frame_sensor,
                                            const HeightMapOptions& options = {});

}  // namespace palpate::tactile
