// SPDX-License-Identifier: Apache-2.0
// Add a skill: a Phase with a name, a time limit, and an end that depends on what the hand sensed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <optional>

#include "hand_over_floor.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "palpate/skills/executor.hpp"
#include "palpate/skills/phase.hpp"
#include "palpate/tactile/contacts/finger_sample.hpp"

namespace palpate::skills {
namespace {

struct TapOptions {
  double depth = 0.1;   ///< m that the hand goes down, at most
  double speed = 0.02;  ///< m/s
  double force = 0.5;   ///< N on all fingertips together that counts as a touch
};

/// Height of the contacts in the world, m, if their forces add up to more than that (N).
std::optional<double> touched_height(const hand::HandReading& reading,
                                     const hand::Description& model, double force) {
  double total = 0, weighted = 0;
  for (int finger = 0; finger < model.finger_count(); ++finger) {
    for (const auto& contact : tactile::finger_frame(reading, model, finger).contacts) {
      total += contact.f.norm();
      weighted += contact.f.norm() * contact.p.z();
    }
  }
  if (total <= force) return std::nullopt;
  return weighted / total;
}

/// Lowers the hand until it touches something, and lifts it to where it came from.
class TapPhase : public Phase {
 public:
  explicit TapPhase(const TapOptions& options = {}) : options_(options) {}
  std::string_view name() const override { return "tap"; }
  double time_limit() const override { return 3 * options_.depth / options_.speed; }

  PhaseEnd run(Executor& robot, PickState& state) override {
    const hand::MountPosition start = robot.command().mount;
    hand::MountPosition lowest = start;
    lowest.xyz.z() -= options_.depth;
    const auto touched = [&](const hand::HandReading& reading) {
      return touched_height(reading, robot.model(), options_.force);
    };
    robot.move_mount(lowest, options_.speed,
                     [&](const auto& reading) { return touched(reading).has_value(); });
    const auto height = touched(robot.reading());
    robot.move_mount(start, options_.speed);
    if (!height) return {false, "nothing there"};
    state.height = *height;  // for the phases that follow
    return {true, fmt::format("touched at {:.1f} mm", 1e3 * *height)};
  }

 private:
  TapOptions options_;
};

/// The phase with a hand that starts at the origin above a floor at this height (m).
PhaseReport tap(double floor, PickState& state) {
  const auto model = simulation::describe_hand(PALPATE_EXAMPLES "/hands/three_fingers.xml").hand;
  hand::HandOverFloor hand(model, floor);
  hand::HandCommand start;
  start.positions = hand::ActuatorVector::Zero(model.actuator_count());
  Executor robot(hand, model, start);
  TapPhase phase;
  return run_phase(phase, robot, state);
}

TEST(TapPhase, ReportsWhereItTouched) {
  PickState state;
  const PhaseReport report = tap(-0.05, state);
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_NEAR(state.height, -0.05, 0.001);
}

TEST(TapPhase, FailsWhereNothingIs) {
  PickState state;
  const PhaseReport report = tap(-0.5, state);
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_EQ(report.outcome, "nothing there");
}

}  // namespace
}  // namespace palpate::skills
