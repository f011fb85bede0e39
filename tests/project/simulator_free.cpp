// SPDX-License-Identifier: Apache-2.0
// Links estimation, skills and recording, and lets a phase run on a hand that is no simulation:
// what a user without MuJoCo builds. project.no_simulator checks what it loads.
#include <cstdio>

#include "hand/fake_hand.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/skills/explore/height_probe_phase.hpp"
#include "palpate/skills/pick.hpp"
#include "palpate/skills/place/pick_and_place.hpp"

int main() {
  using namespace palpate;
  hand::FakeHand fake;
  skills::Executor robot(fake, hand::with_soft_actuators(), hand::resting_command());
  skills::HeightProbePhase phase(skills::HeightProbeOptions{});
  skills::PickState state;
  const skills::PhaseReport report = skills::run_phase(phase, robot, state);
  std::printf("%s: %s\n", report.name.c_str(), report.outcome.c_str());
  // Nothing stands on this table; what matters is that the whole pick and place is linked.
  skills::PickResult (*volatile pick)(
      skills::Executor&, const estimation::Candidates&, const skills::PickOptions&, std::uint64_t,
      const skills::PhaseObserver&, const skills::GraspChooser&) = &skills::pick;
  auto* volatile pick_and_place = &skills::pick_and_place;
  const auto volatile estimate = &estimation::PoseEstimator::held;
  auto* volatile log_of = &recording::event_log;
  const bool linked = pick && pick_and_place && estimate && log_of;
  return linked && report.status == skills::PhaseStatus::failed ? 0 : 1;
}
