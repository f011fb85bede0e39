// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/learning/checkpoint.hpp"
#include "palpate/learning/policy.hpp"

namespace palpate::learning {

/// Keeps the record of an MLP policy in a checkpoint, as arrays named "policy_...".
void save_mlp(const PolicyRecord& record, Checkpoint& checkpoint);

/// @throws BadInput if one of the arrays is missing
PolicyRecord restore_mlp(const Checkpoint& checkpoint);

}  // namespace palpate::learning
