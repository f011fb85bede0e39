// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpate/skills/pick.hpp"

namespace palpate::skills {

/// Runs phases one after the other, keeps their reports, and remembers which failed last. One that
/// a fault has stopped ends the sequence by SafetyStop.
class PhaseSequence {
 public:
  PhaseSequence(Executor& robot, PickState& state, std::vector<PhaseReport>& reports,
                std::string& failed_phase, const PhaseObserver& observer)
      : robot_(robot),
        state_(state),
        reports_(reports),
        failed_phase_(failed_phase),
        observer_(observer) {}

  bool run(Phase& phase) {
    if (observer_.on_begin) observer_.on_begin(phase.name(), robot_.time());
    reports_.push_back(run_phase(phase, robot_, state_));
    const PhaseReport& report = reports_.back();
    if (observer_.on_end) observer_.on_end(report, robot_.time());
    const bool ok = report.status == PhaseStatus::ok;
    if (!ok) failed_phase_ = report.name;
    robot_.require_running();
    return ok;
  }
  bool run(Phase&& phase) { return run(phase); }

 private:
  Executor& robot_;
  PickState& state_;
  std::vector<PhaseReport>& reports_;
  std::string& failed_phase_;
  const PhaseObserver& observer_;
};

}  // namespace palpate::skills
