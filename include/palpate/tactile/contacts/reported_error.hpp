// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::tactile {

/// Whether a number can be one: finite and not negative.
bool is_standard_deviation(double sigma);

/// Whether the errors that a contact reports can be standard deviations (0: none is reported).
bool has_valid_errors(const hand::TipContact& contact);

}  // namespace palpate::tactile
