// SPDX-License-Identifier: Apache-2.0
#include "estimation/log_evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/shadow.hpp"
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

/// A hand that closed at the table, lifted, turned aside and let the object down.
EventLog one_table_touch() {
  EventLog log = one_touch();
  for (auto& reading : log.readings) reading.mount.xyz = {0.1, 0, 0.3};
  log.readings[20].mount = {{0.1, 0, 0.22}, {0.4, 0.3, -0.1}};
  log.moments = {{TouchEvent::closed, 5},
                 {TouchEvent::held, 10},
                 {TouchEvent::table_touched, 20},
                 {TouchEvent::held, 29}};
  return log;
}

TEST(EvidenceInHand, HoldsWhereTheTableWasWhenTheHeldObjectTouchedIt) {
  static const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  const EventLog log = one_table_touch();
  const auto evidence = evidence_in_hand(hand, log, {29, true}, 0.2, {});
  ASSERT_EQ(evidence.planes.size(), 1u);
  const auto& plane = evidence.planes.front();
  const Eigen::Isometry3d T_mount_world = log.readings[20].mount.pose().inverse();
  EXPECT_NEAR((plane.normal - T_mount_world.linear().col(2)).norm(), 0, 1e-9);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.3, -0.2, 0)}) {
    EXPECT_NEAR(plane.normal.dot(T_mount_world * p), plane.height, 1e-9);  // of the table
  }
  EXPECT_EQ(evidence_in_hand(hand, log, {5, false}, 0.2, {}).planes.size(), 1u)
      << "all of the log counts, before and after the instant";
}

TEST(EvidenceInHand, IsLessSureOfTouchesOfTheTableAfterWhichTheObjectMayHaveTurned) {
  static const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  EventLog log = one_table_touch();
  log.moments.insert(log.moments.end() - 1, {TouchEvent::table_touched, 25});
  EstimationOptions options;
  options.table_touch_sigma = 0.003;
  options.probe_motion = 0.004;
  const auto evidence = evidence_in_hand(hand, log, {29, true}, 0.2, options);
  ASSERT_EQ(evidence.planes.size(), 2u);
  EXPECT_NEAR(evidence.planes[0].sigma, 0.005, 1e-12);
  EXPECT_NEAR(evidence.planes[1].sigma, 0.003, 1e-12);
}

/// A hand that closed and moved the first finger to another spot, which it touches.
EventLog one_probe(const hand::Description& hand) {
  EventLog log = one_touch();
  const auto knuckle = hand::shadow_hand().joint("FFJ3");
  for (std::size_t i = 10; i < log.readings.size(); ++i) log.readings[i].joints[knuckle] = 0.5;
  for (std::size_t i = 26; i < log.readings.size(); ++i) {
    log.readings[i].joints = log.readings[0].joints;
  }
  EXPECT_EQ(hand.finger_count(), hand::kShadowFingers);
  log.moments = {{TouchEvent::closed, 5}, {TouchEvent::probed, 25}, {TouchEvent::closed, 29}};
  return log;
}

TEST(EvidenceInHand, CountsWhatAProbeTouchedUntilTheHandOpens) {
  static const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  EventLog log = one_probe(hand);
  EventLog without = log;
  std::erase_if(without.moments,
                [](const auto& moment) { return moment.event == TouchEvent::probed; });
  const auto count = [&](const EventLog& one) {
    return evidence_in_hand(hand, one, {29, false}, 0.2, {}).contacts.size();
  };
  EXPECT_EQ(count(log), count(without) + 1);
  log.moments.insert(log.moments.end() - 1, {TouchEvent::opened, 27});
  EXPECT_EQ(count(log), count(without));
}

}  // namespace
}  // namespace palpate::estimation
