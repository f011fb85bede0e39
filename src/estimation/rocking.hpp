// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/se3.hpp"
#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::estimation {

/// By how much light pushes may tilt an object that rests on a plane: about each horizontal axis
/// until its centroid has risen by a given energy, and no farther than its top may be pushed. A
/// banana rocks, a book does not.
/// @param T_frame_object  where it rests
/// @param up              the plane's normal in the frame
/// @return of rotation and translation, about the point below the centroid, where the object stands
Matrix6d rocking_covariance(const geometry::KnownObject& object,
                            const Eigen::Isometry3d& T_frame_object, const Eigen::Vector3d& up);

}  // namespace palpate::estimation
