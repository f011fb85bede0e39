// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpate/localization/evidence.hpp"

namespace palpate::app {

/// The object rests on a table at that height, somewhere under the contacts or within its own size
/// of them; without contacts of where the prior has it, and without that about the origin.
localization::TableSupport table_at(double height, const localization::Evidence& evidence,
                                    const geometry::KnownObject& object);

/// The posterior of a report of `palpate localize --json`, given that it is of the object that the
/// report names, as a prior in the same frame.
/// @param object  name or file of the object
/// @throws BadInput for a file that is no such report, is of another object or has no modes
localization::PosePrior read_prior(const std::filesystem::path& path, const std::string& object,
                                   const Eigen::Isometry3d& T_mesh_object);

/// Covariance of [rotation; translation] of a pose whose origin is moved by `arm`, in the frame's
/// axes, from that of the pose itself.
Matrix6d covariance_at(const Eigen::Vector3d& arm, const Matrix6d& covariance);

/// A file of contacts, as it was read.
struct ContactFile {
  std::string name, text;
  std::vector<tactile::Contact> contacts;
};

/// Refuses contacts of which a few lie far from the others, by their lines.
/// @param size  of the object, m
/// @throws BadInput
void check_together(const ContactFile& file, double size);

}  // namespace palpate::app
