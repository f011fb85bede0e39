// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/localization/evidence.hpp"

namespace palpate::app {

/// The object rests on a table at that height, somewhere under the contacts or within its own size
/// of them; without contacts about the origin.
localization::TableSupport table_at(double height, const std::vector<tactile::Contact>& contacts,
                                    const geometry::KnownObject& object);

/// The modes of a report of `palpate localize --json`, as a prior in the same frame.
/// @throws BadInput for a file that is no such report or has no modes
localization::PosePrior read_prior(const std::filesystem::path& path,
                                   const Eigen::Isometry3d& T_mesh_object);

/// Covariance of [rotation; translation] of a pose whose origin is moved by `arm`, in the frame's
/// axes, from that of the pose itself.
Matrix6d covariance_at(const Eigen::Vector3d& arm, const Matrix6d& covariance);

}  // namespace palpate::app
