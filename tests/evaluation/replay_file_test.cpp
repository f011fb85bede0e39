// SPDX-License-Identifier: Apache-2.0
#include "replay_file.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::app {
namespace {

TEST(VisualsOf, AreThoseOfTheRecordedHandsFile) {
  hand::Description hand = simulation::load_hand("shadow");
  EXPECT_FALSE(visuals_of(hand).parts.empty());
  // Of an episode by touch, which is of another hand in the Shadow hand's links.
  hand.links[2].T_parent_link.translation().x() += 0.01;
  EXPECT_FALSE(visuals_of(hand).parts.empty());
}

// The recorded links are those that are believed, some millimetres off.
TEST(VisualsOf, AreThoseOfAUsersHand) {
  simulation::WorldOptions options = simulation::WorldOptions::realistic();
  options.hand = PALPATE_EXAMPLES "/hands/three_fingers.xml";
  const simulation::World world(geometry::load_known_object("box"), options, 3);
  const auto& believed = world.hand_model();
  EXPECT_GT((believed.links[2].T_parent_link.translation() -
             simulation::load_hand(options.hand).links[2].T_parent_link.translation())
                .norm(),
            1e-4);
  EXPECT_FALSE(visuals_of(believed).parts.empty());
}

TEST(VisualsOf, AreNoneWhereTheFileIsNot) {
  hand::Description hand = simulation::load_hand("shadow");
  hand.name = "folder/my_hand.xml";
  testing::internal::CaptureStderr();
  EXPECT_TRUE(visuals_of(hand).parts.empty());
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("recorded spheres"), said.npos);
  EXPECT_NE(said.find("folder/my_hand.xml"), said.npos);
  EXPECT_THROW(load_recorded_hand(hand), BadInput);
}

TEST(SameLinks, DifferByNameParentOrPlace) {
  const hand::Description hand = simulation::load_hand("shadow");
  EXPECT_TRUE(same_links(hand, simulation::load_hand("shadow")));
  EXPECT_FALSE(same_links(hand, simulation::load_hand("shadow-left")));
  auto other = hand;
  other.links[5].name = "tip";
  EXPECT_FALSE(same_links(hand, other));
  other = hand;
  other.links[5].parent = 0;
  EXPECT_FALSE(same_links(hand, other));
  other = hand;
  other.links[5].T_parent_link.translation().z() += 5e-3;  // what is believed of it
  EXPECT_TRUE(same_links(hand, other));
  other.links[5].T_parent_link.translation().z() += 0.03;
  EXPECT_FALSE(same_links(hand, other));
  other = hand;
  other.links.pop_back();
  EXPECT_FALSE(same_links(hand, other));
}

}  // namespace
}  // namespace palpate::app
