// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// Mean place over the table of the fingertip contacts sensed last, if any was sensed, m.
std::optional<Eigen::Vector2d> place_of_last_contacts(const Executor& robot);

}  // namespace palpate::skills
