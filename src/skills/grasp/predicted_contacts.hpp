// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/skills/executor.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::skills {

/// Adds the contacts (mount's frame) of fingers that are not believed where the object's pose says
/// that they touch it.
void add_predicted_contacts(const Executor& robot, const geometry::ObjectModel& object,
                            const Eigen::Isometry3d& T_world_object,
                            std::vector<tactile::Contact>& contacts);

}  // namespace palpate::skills
