// SPDX-License-Identifier: Apache-2.0
#include "estimation/closing_push.hpp"

#include <gtest/gtest.h>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kReadings = 60;
constexpr double kStep = 1e-4;  // m a reading
constexpr int kLate = 4;        // readings, that the first place lags behind

const hand::Description& shadow() {
  static const hand::Description hand =
      simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  return hand;
}

/// The hand goes along x; one finger touches from some reading on, against a normal in the world.
EventLog pushing(std::size_t from, const Eigen::Vector3d& normal) {
  const hand::Description& hand = shadow();
  EventLog log;
  for (std::size_t i = 0; i < kReadings; ++i) {
    hand::HandReading reading = hand::resting_reading();
    reading.mount.xyz.x() += kStep * static_cast<double>(i);
    if (i >= from) {
      const auto T = hand::forward_kinematics(hand, reading.joints);
      const auto link = static_cast<std::size_t>(hand.fingers[1].link);
      const Eigen::Vector3d n = (reading.mount.pose() * T[link]).linear().transpose() * normal;
      reading.contacts[1] = {{{0, 0.007, 0.01}, n, -n}};
    }
    log.readings.push_back(reading);
  }
  return log;
}

double push(const EventLog& log) { return closing_push(shadow(), log, log.readings.size() - 1); }

TEST(ClosingPush, IsTheWayOfAFingertipSinceItMetTheObject) {
  EXPECT_NEAR(push(pushing(20, {-1, 0, 0})), (39 - kLate) * kStep, 1e-9);
  EXPECT_NEAR(push(pushing(40, {-1, 0, 0})), (19 - kLate) * kStep, 1e-9);
}

TEST(ClosingPush, IsNoneAlongTheSurfaceNorAwayFromIt) {
  EXPECT_NEAR(push(pushing(20, {0, 0, 1})), 0, 1e-9);
  EXPECT_EQ(push(pushing(20, {1, 0, 0})), 0);
}

TEST(ClosingPush, StartsAgainWhereTheFingerHadLetGo) {
  EventLog log = pushing(0, {-1, 0, 0});
  for (std::size_t i = 25; i < 40; ++i) log.readings[i].contacts[1].clear();
  EXPECT_NEAR(push(log), (19 - kLate) * kStep, 1e-9);
  for (std::size_t i = 45; i < 50; ++i) log.readings[i].contacts[1].clear();  // a flicker
  EXPECT_NEAR(push(log), (19 - kLate) * kStep, 1e-9);
}

TEST(ClosingPush, IsNoneOfAHandThatTouchesNothing) {
  EXPECT_EQ(push(pushing(kReadings, {-1, 0, 0})), 0);
}

}  // namespace
}  // namespace palpate::estimation
