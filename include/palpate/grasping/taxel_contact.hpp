// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/grasping/grasp_matrix.hpp"
#include "palpate/tactile/biotac/skin.hpp"

namespace palpate::grasping {

/// The loaded taxels as contacts, each with its own frame, in the sensor frame, and their wrenches
/// (6 n) in these frames.
struct TaxelGrasp {
  grasping::GraspContacts contacts;
  Eigen::VectorXd wrenches;
};
TaxelGrasp taxel_grasp(const tactile::BiotacSkin& skin, const tactile::SkinState& state);

/// Contact point (sensor frame) and force of all taxels together, as the thesis has it
/// (section 5.1): the grasp matrix of the taxels' frames sums their forces up to one wrench
/// (eq. 4.7); the contact is where its axis leaves the skin (Bicchi, Salisbury & Brock 1993,
/// without a moment about the normal).
/// @return nothing without a force, or where the axis misses the skin
std::optional<hand::TipContact> contact_of_taxels(const tactile::BiotacSkin& skin,
                                                  const tactile::SkinState& state);

}  // namespace palpate::grasping
