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
  skills::Robot robot(fake, hand::HandModel{}, {});
  skills::FeelPhase phase(skills::FeelOptions{});
  skills::PickState state;
  const skills::PhaseReport report = skills::run_phase(phase, robot, state);
  std::printf("%s: %s\n", report.name.c_str(), report.outcome.c_str());
  // Nothing stands on this table; what matters is that the whole pick and place is linked.
  const bool linked = &skills::pick != nullptr && &skills::pick_and_place != nullptr &&
                      &estimation::locate != nullptr && &recording::touch_log != nullptr;
  return linked && report.status == skills::PhaseStatus::failed ? 0 : 1;
}
