// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <utility>

#include "palpate/hand/hand.hpp"

namespace palpate::python {

/// A hand that says what it is, as Python knows hands.
class DescribedHand : public hand::Hand {
 public:
  explicit DescribedHand(hand::Description description) : description_(std::move(description)) {}
  [[nodiscard]] const hand::Description& description() const { return description_; }

 private:
  hand::Description description_;
};

/// A hand whose step() is Python's. What that raises, or answers wrongly, is thrown as a
/// std::runtime_error, which the executor takes for a fault of the hand; the first exception is
/// kept.
struct PythonHand : DescribedHand {
  using DescribedHand::DescribedHand;

  nanobind::object raised;  ///< the first that step() raised; to be touched with the GIL alone
};

}  // namespace palpate::python
