// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand/descriptions.hpp"
#include "hand/fake_hand.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/biotac_reading.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/tactile/biotac/contact_hand.hpp"
#include "palpate/tactile/biotac/dataset.hpp"
#include "palpate/tactile/biotac/skin.hpp"
#include "tactile/one_link_hand.hpp"

namespace palpate::tactile {
namespace {

std::shared_ptr<const tactile::BiotacInverse> inverse() {
  static const auto model = [] {
    tactile::BiotacDatasetOptions options;
    options.trajectories = 20;
    options.seconds = 1;
    return std::make_shared<const tactile::BiotacInverse>(
        tactile::BiotacInverse::train(tactile::simulate_biotac(options)));
  }();
  return model;
}

TEST(BiotacHand, SensesByTheChannelsAlone) {
  const hand::TipContact touch{.p = {-0.003, 0, -0.007}, .n = {0, 0, 1}, .f = {0.3, 0.2, -2}};
  const tactile::BiotacSkin skin;
  tactile::BiotacSensor sensor(skin, {}, RandomStream(7));
  int frames = 0;
  // Contacts that the channels do not show, and channels that show one from a while on.
  hand::FakeHand fake([&](hand::HandReading& reading) {
    reading.contacts[1] = {touch, touch};
    const bool touches = ++frames > 40;
    hand::BiotacReading channels =
        sensor.step(touches ? skin.press({&touch, 1}) : tactile::SkinState{});
    channels.time = reading.time;
    reading.biotacs.assign(hand::kShadowFingers, channels);
  });
  BiotacHand hand(fake, hand::one_link_hand(), inverse());
  const hand::HandCommand command = hand::resting_command();
  for (int k = 0; k < 40; ++k) EXPECT_TRUE(hand.step(command).contacts[1].empty()) << k;
  hand::HandReading last = hand::resting_reading();
  for (int k = 0; k < 40; ++k) last = hand.step(command);
  ASSERT_EQ(last.contacts[1].size(), 1u);
  EXPECT_GT(last.contacts[1][0].normal_sigma, 0);
}

TEST(BiotacHand, RefusesAHandWithoutChannels) {
  hand::FakeHand insensitive;
  BiotacHand hand(insensitive, hand::one_link_hand(), inverse());
  EXPECT_THROW(hand.step(hand::resting_command()), BadInput);
}

}  // namespace
}  // namespace palpate::tactile
