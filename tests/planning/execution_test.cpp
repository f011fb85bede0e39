// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/execution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hand/descriptions.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::planning {
namespace {

/// A hand that is always where it was commanded to be a tick ago.
class LateHand : public hand::Hand {
 public:
  hand::HandReading step(const hand::HandCommand& command) override {
    hand::HandReading reading = hand::resting_reading();
    reading.joints = hand::joints_in_free_flexion(hand::shadow_hand(), last_.positions);
    reading.mount = last_.mount;
    last_ = command;
    return reading;
  }

 private:
  hand::HandCommand last_ = hand::resting_command();
};

TEST(Execute, MeasuresTheLagOfWhatMoves) {
  std::vector<hand::HandCommand> samples(101, hand::resting_command());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].positions[hand::shadow_hand().actuator("FFJ0")] = 0.01 * static_cast<double>(i);
    samples[i].mount.xyz.x() = 0.002 * static_cast<double>(i);
  }
  LateHand hand;
  const TrackingError error = execute(hand, hand::shadow_hand(), samples, {.mount_lead = 0});
  EXPECT_NEAR(error.joint_max, 0.01, 1e-12);
  EXPECT_NEAR(error.joint_rms, 0.01 * std::sqrt(100.0 / 101.0), 1e-12);
  EXPECT_NEAR(error.mount_max, 0.002, 1e-12);
  EXPECT_NEAR(error.mount_rms, 0.002 * std::sqrt(100.0 / 101.0), 1e-12);
  EXPECT_EQ(error.turn_rms, 0);
  EXPECT_EQ(error.measured.size(), samples.size());
}

TEST(Execute, LeadMakesUpForALateMount) {
  std::vector<hand::HandCommand> samples(50, hand::resting_command());
  for (std::size_t i = 1; i < samples.size(); ++i) {
    samples[i].mount.xyz.z() = std::sin(0.1 * static_cast<double>(i));
  }
  LateHand hand;
  EXPECT_NEAR(execute(hand, hand::shadow_hand(), samples, {.mount_lead = hand::kTick}).mount_max, 0,
              1e-12);
}

TEST(Execute, NothingIsNoError) {
  LateHand hand;
  EXPECT_EQ(execute(hand, hand::shadow_hand(), {}).joint_rms, 0);
}

}  // namespace
}  // namespace palpate::planning
