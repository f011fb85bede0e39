// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/believed_hand.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

/// A finger whose first body turns about two axes that do not meet.
constexpr const char* kFinger = R"(
<mujoco>
  <worldbody>
    <body name="palm">
      <geom size="0.02"/>
      <body name="knuckle" pos="0.05 0.01 0">
        <joint name="spread" axis="0 0 1"/>
        <joint name="bend" axis="0 1 0" pos="0.003 0 0"/>
        <geom size="0.01"/>
        <body name="tip" pos="0.04 0 0.002">
          <joint name="curl" axis="0 1 0"/>
          <geom name="tip" type="capsule" size="0.007 0.01"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>)";

struct Finger {
  Finger() {
    std::array<char, 1000> message{};
    const SpecHandle spec(mj_parseXMLString(kFinger, nullptr, message.data(), message.size()));
    model = compile(*spec);
    hand.joints = {{"spread", {-1, 1}}, {"bend", {-1, 1}}, {"curl", {-1, 1}}};
    hand.fingers.resize(1);
    const auto joint = [&](const std::string& name) { return NamedJoint{hand.joint(name), 1}; };
    read_links(*model, find_id(*model, mjOBJ_BODY, "palm"), "palm", joint,
               {find_id(*model, mjOBJ_GEOM, "tip")}, hand);
  }
  Eigen::Vector3d position(const char* body) const {
    return Eigen::Vector3d::Map(model->body_pos + 3 * find_id(*model, mjOBJ_BODY, body));
  }
  hand::Link& link(const std::string& name) {
    return *std::find_if(hand.links.begin(), hand.links.end(),
                         [&](const hand::Link& link) { return link.name == name; });
  }

  ModelHandle model;
  hand::Description hand;
};

TEST(PlaceLinks, LeavesABodyOfSeveralLinksWhereItsDrawingHasIt) {
  Finger finger;
  ASSERT_EQ(finger.hand.links.size(), 5u);  // palm, two hinges, the knuckle and the tip
  place_links(finger.hand, *finger.model);
  EXPECT_LT((finger.position("knuckle") - Eigen::Vector3d(0.05, 0.01, 0)).norm(), 1e-15);
  EXPECT_LT((finger.position("tip") - Eigen::Vector3d(0.04, 0, 0.002)).norm(), 1e-15);
}

TEST(PlaceLinks, DisplacesTheBodyWithItsFirstLink) {
  Finger finger;
  finger.link("knuckle.spread").T_parent_link.translation().y() += 0.002;
  place_links(finger.hand, *finger.model);
  EXPECT_LT((finger.position("knuckle") - Eigen::Vector3d(0.05, 0.012, 0)).norm(), 1e-15);
  EXPECT_LT((finger.position("tip") - Eigen::Vector3d(0.04, 0, 0.002)).norm(), 1e-15);
}

TEST(PlaceLinks, RefusesALinkThatTheModelLacks) {
  for (const char* name : {"knuckle", "tip"}) {
    Finger finger;
    finger.link(name).name = "tentacle";
    EXPECT_THROW(place_links(finger.hand, *finger.model), BadInput) << name;
  }
}

}  // namespace
}  // namespace palpate::simulation
