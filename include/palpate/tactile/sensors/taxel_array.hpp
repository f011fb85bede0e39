// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::tactile {

/// One cell of a pressure-sensitive skin.
struct Taxel {
  Eigen::Vector3d p;  ///< middle, sensor's frame, m
  Eigen::Vector3d n;  ///< outward unit normal of the skin there
  double force = 0;   ///< N, of the object on the skin along -n
};

struct TaxelOptions {
  double min_force = 0.05;     ///< N above which a taxel touches
  double pitch = 0.004;        ///< m between taxels: a contact may lie anywhere on one
  double normal_sigma = 0.35;  ///< rad, by which the object's normal differs from the skin's
};

/// A contact at each taxel that touches. The object's outward normal is opposite to the skin's, the
/// force of the skin on the object goes along the skin's, and the error of the point is that of a
/// uniform spread over a taxel, pitch / sqrt(12) per axis.
///
/// @param T_frame_sensor  of the sensor in the frame of the contacts
/// @throws BadInput, naming the taxel, for values that are not finite or a normal that is not of
///         unit length to 1e-3, and for options that are not positive
std::vector<Contact> contacts_of_taxels(const std::vector<Taxel>& taxels,
                                        const Eigen::Isometry3d& T_frame_sensor,
                                        const TaxelOptions& options = {});

}  // namespace palpate::tactile
