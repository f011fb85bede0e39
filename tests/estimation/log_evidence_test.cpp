// SPDX-License-Identifier: Apache-2.0
#include "estimation/log_evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::estimation {
namespace {

/// A guarded move at whose end a fingertip touches.
EventLog one_touch() {
  EventLog log;
  for (std::size_t i = 0; i < 30; ++i) {
    hand::HandReading reading = hand::resting_reading();
    reading.time = static_cast<double>(i) * hand::kTick;
    reading.contacts[1] = {{{0, 0.007, 0.01}, {0, -1, 0}, {0, 0.2, 0}}};
    log.readings.push_back(reading);
  }
  log.moments = {{TouchEvent::guarded_move, 0}, {TouchEvent::touched, 29}};
  return log;
}

double touched_sigma(double mass) {
  static const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  const auto evidence = evidence_of_guarded_moves(hand, one_touch(), {}, mass, 0);
  EXPECT_EQ(evidence.contacts.size(), 1u);
  return evidence.contacts.at(0).point_sigma;
}

TEST(EvidenceOfGuardedMoves, IsLessSureOfLightObjectsWhichTouchesPush) {
  const double heavy = touched_sigma(1e6), light = touched_sigma(0.05);
  EXPECT_GT(heavy, 0);
  EXPECT_NEAR(light * light - heavy * heavy, 0.0004 * 0.0004, 1e-9);
  EXPECT_NEAR(std::pow(touched_sigma(0.2), 2) - heavy * heavy, 0.0001 * 0.0001, 1e-9);
  EXPECT_EQ(touched_sigma(0.01), light) << "none is pushed farther";
}

}  // namespace
}  // namespace palpate::estimation
