// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/biotac_hand.hpp"

#include <gtest/gtest.h>

#include "fake_hand.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/biotac_reading.hpp"
#include "palpate/pipeline/trial.hpp"
#include "palpate/touch/biotac_dataset.hpp"
#include "palpate/touch/biotac_skin.hpp"
#include "touch/one_link_hand.hpp"

namespace palpate::pipeline {
namespace {

std::shared_ptr<const touch::BiotacInverse> inverse() {
  static const auto model = [] {
    touch::BiotacDatasetOptions options;
    options.trajectories = 20;
    options.seconds = 1;
    return std::make_shared<const touch::BiotacInverse>(
        touch::BiotacInverse::train(touch::simulate_biotac(options)));
  }();
  return model;
}

TEST(BiotacHand, FeelsByTheChannelsAlone) {
  const hand::TipContact touch{.p = {-0.003, 0, -0.007}, .n = {0, 0, 1}, .f = {0.3, 0.2, -2}};
  const touch::BiotacSkin skin;
  touch::BiotacSensor sensor(skin, {}, RandomStream(7));
  int frames = 0;
  // Contacts that the channels do not tell of, and channels that tell of one from a while on.
  FakeHand felt([&](hand::HandReading& reading) {
    reading.contacts[1] = {touch, touch};
    const bool touches = ++frames > 40;
    hand::BiotacReading channels =
        sensor.step(touches ? skin.press({&touch, 1}) : touch::SkinState{});
    channels.time = reading.time;
    reading.biotacs.assign(hand::kFingers, channels);
  });
  BiotacHand hand(felt, hand::one_link_hand(), inverse());
  EXPECT_EQ(&hand.actuators(), &felt.actuators());
  for (int k = 0; k < 40; ++k) EXPECT_TRUE(hand.step({}).contacts[1].empty()) << k;
  hand::HandReading last;
  for (int k = 0; k < 40; ++k) last = hand.step({});
  ASSERT_EQ(last.contacts[1].size(), 1u);
  EXPECT_GT(last.contacts[1][0].normal_sigma, 0);
}

TEST(TouchOptions, SayHowFarInferredContactsMayBeOff) {
  TrialOptions options;
  EXPECT_EQ(options.pick_options().locate.errors.point_floor, LocateOptions().errors.point_floor);
  options.touch = {
      .source = "biotac", .biotac_point = 0.003, .biotac_normal = 0.4, .biotac_false = 0.07};
  const LocateOptions locate = options.pick_options().locate;
  EXPECT_EQ(locate.errors.point_floor, 0.003);
  EXPECT_EQ(locate.errors.normal_floor, 0.4);
  EXPECT_EQ(locate.false_contacts, 0.07);
  options.touch.source = "nose";
  EXPECT_THROW((void)options.pick_options(), BadInput);
}

TEST(BiotacHand, RefusesAHandWithoutChannels) {
  FakeHand numb;
  BiotacHand hand(numb, hand::one_link_hand(), inverse());
  EXPECT_THROW(hand.step({}), BadInput);
}

}  // namespace
}  // namespace palpate::pipeline
