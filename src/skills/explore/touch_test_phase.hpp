// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/skills/explore/calibrate_phase.hpp"
#include "skills/explore/table_press.hpp"

namespace palpate::skills {

/// Presses the fingertips on the bare table that something has held up without their sensing it
/// (Executor::suspects). One that does not sense the table, either, is no longer believed: the
/// fault touch_lost, with which the robot goes on. Two of which either reports what the other one
/// touches are swapped from then on (touch_swapped).
class TouchTestPhase : public Phase {
 public:
  explicit TouchTestPhase(const CalibrateOptions& options) : options_(options) {}
  std::string_view name() const override { return "touch-test"; }
  double time_limit() const override;
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  enum class Result { sensitive, insensitive, untested };

  Result test(Executor& robot, double clear_height, int finger, UnsensedPresses& unsensed) const;
  [[nodiscard]] std::optional<int> swapped_with(Executor& robot, double clear_height, int finger,
                                                UnsensedPresses& unsensed) const;

  CalibrateOptions options_;
};

}  // namespace palpate::skills
