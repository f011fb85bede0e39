// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace palpate {

/// Input that cannot be used; the message is one line and names the offending value.
class BadInput : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace palpate
