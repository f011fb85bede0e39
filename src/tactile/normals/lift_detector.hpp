// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "palpate/tactile/contacts/finger_sample.hpp"

namespace palpate::tactile {

/// Tells which samples begin a contact: those that come so long after the last usable one, or so
/// far from it, that the finger may have left the surface in between.
class LiftDetector {
 public:
  /// @param forget_after  s without a usable sample after which any begins a contact
  explicit LiftDetector(double forget_after) : forget_after_(forget_after) {}

  /// Takes the next sample, usable or not.
  /// @return whether it is usable and the first of a contact
  bool begins(const FingerSample& sample);

 private:
  struct Step {
    double time = 0, length = 0;  // s, m
  };

  bool lifted(const Step& step) const;
  double usual(double Step::*value) const;

  double forget_after_;
  bool away_ = false;  // no contact or no force since the last usable sample
  std::optional<FingerSample> last_;
  std::deque<Step> steps_;  // the latest between usable samples
};

}  // namespace palpate::tactile
