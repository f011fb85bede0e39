// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/reported_error.hpp"

#include <cmath>

namespace palpate::tactile {

bool is_standard_deviation(double sigma) { return std::isfinite(sigma) && sigma >= 0; }

bool has_valid_errors(const hand::TipContact& contact) {
  return is_standard_deviation(contact.point_sigma) && is_standard_deviation(contact.normal_sigma);
}

}  // namespace palpate::tactile
