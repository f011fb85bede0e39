// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate {

/// A key that no option of a struct has.
class UnknownOption : public BadInput {
 public:
  UnknownOption(const std::string& message, std::string key)
      : BadInput(message), key_(std::move(key)) {}
  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace palpate
