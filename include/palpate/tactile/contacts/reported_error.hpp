// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::tactile {

/// Whether a number can be one: finite and not negative.
bool is_standard_deviation(double sigma);

/// Whether what a contact tells of its errors can be standard deviations (0: it tells nothing).
bool tells_sound_errors(const hand::TipContact& contact);

}  // namespace palpate::tactile
