// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/hand_store.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/core/error.hpp"

namespace palpate::simulation {
namespace {

TEST(HandStore, EveryHandHasItsMakerAndLicence) {
  const auto hands = stored_hands();
  for (const char* name : {"shadow", "allegro", "leap", "barrett"}) {
    const auto found = std::ranges::find(hands, name, &StoredHand::name);
    ASSERT_NE(found, hands.end()) << name;
    EXPECT_FALSE(found->maker.empty()) << name;
    EXPECT_FALSE(found->licence.empty()) << name;
  }
}

TEST(HandStore, TheShadowHandIsThere) {
  EXPECT_TRUE(std::filesystem::exists(stored_hands().front().file));
}

TEST(HandStore, AnUnknownHandIsNeitherInstalledNorCanBe) {
  EXPECT_TRUE(installed_hand("nobody").empty());
  EXPECT_THROW((void)install_hand("nobody"), BadInput);
}

}  // namespace
}  // namespace palpate::simulation
