// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/core/error.hpp"

namespace palpate {

/// What the BadInput that `action` throws says; empty if it throws none.
template <class Action>
std::string error_message(const Action& action) {
  try {
    action();
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace palpate
