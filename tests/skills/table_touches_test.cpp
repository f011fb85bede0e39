// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/table_touches.hpp"

#include <gtest/gtest.h>

#include <set>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "skills/lowest_part.hpp"

namespace palpate::skills {
namespace {

const hand::Description& shadow() {
  static const auto model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  return model;
}

TEST(TableTouches, EachFingertipIsTheLowestPartOfTheHandInSome) {
  const auto touches = telling_touches(shadow(), {});
  ASSERT_EQ(touches.size(), 40);
  std::set<int> fingers;
  for (const TableTouch& touch : touches) {
    fingers.insert(touch.finger);
    const int tip = shadow().fingers[static_cast<std::size_t>(touch.finger)].link;
    EXPECT_EQ(lowest_part(shadow(), touch.posture, touch.attitude),
              lowest_part(shadow(), touch.posture, touch.attitude,
                          [tip](int link) { return link == tip; }));
  }
  EXPECT_EQ(fingers.size(), shadow().fingers.size());
}

TEST(TableTouches, TheNextOneIsNear) {
  const auto touches = telling_touches(shadow(), {});
  const auto turn = [](const TableTouch& a, const TableTouch& b) {
    return std::max({std::abs(a.attitude.pitch - b.attitude.pitch),
                     std::abs(a.attitude.roll - b.attitude.roll),
                     (a.posture - b.posture).cwiseAbs().maxCoeff()});
  };
  double next = 0, any = 0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if (i > 0) next += turn(touches[i - 1], touches[i]) / static_cast<double>(touches.size() - 1);
    for (const TableTouch& other : touches) {
      any += turn(touches[i], other) / static_cast<double>(touches.size() * (touches.size() - 1));
    }
  }
  EXPECT_LT(next, 0.7 * any);
}

}  // namespace
}  // namespace palpate::skills
