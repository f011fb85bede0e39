// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// Where fingers begin and their tips are, straight and bent, m; one each.
struct FingerMotion {
  std::vector<Eigen::Vector3d> bases, straight, bent;
};

/// The finger that closes against the others: it points and moves least like them.
int find_thumb(const FingerMotion& motion);

/// @throws BadInput if no finger has this name
int named_thumb(const hand::Description& hand, const std::string& name);

}  // namespace palpate::simulation
