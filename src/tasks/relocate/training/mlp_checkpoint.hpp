// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/learning/training/checkpoint.hpp"
#include "palpate/tasks/relocate/policies/policy.hpp"

namespace palpate::relocate {

/// Keeps the record of an MLP policy in a checkpoint, as arrays named "policy_...".
void save_mlp(const PolicyRecord& record, learning::Checkpoint& checkpoint);

/// @throws BadInput if one of the arrays is missing
PolicyRecord restore_mlp(const learning::Checkpoint& checkpoint);

}  // namespace palpate::relocate
