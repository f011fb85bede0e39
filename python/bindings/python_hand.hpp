// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <string>
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

/// The first line of what a Python exception says, with its type. Needs the GIL.
std::string one_line(const nanobind::python_error& error);

/// What Python code raised while C++ code called it: the first exception. Needs the GIL.
struct Raised {
  nanobind::object first;

  /// Keeps the exception, and @throws std::runtime_error with its text.
  [[noreturn]] void keep(const nanobind::python_error& error);
};

/// A hand whose step() and sense() are Python's. What they raise, or answer wrongly, is thrown as a
/// std::runtime_error, which the executor takes for a fault of the hand; the first exception is
/// kept.
struct PythonHand : DescribedHand {
  using DescribedHand::DescribedHand;

  Raised raised;
};

}  // namespace palpate::python
