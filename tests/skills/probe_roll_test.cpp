// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/probe_roll.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::skills {
namespace {

constexpr double kNothing = 1e-3;  // nats

/// A box between the thumb below and fingers above; of the fingertips, the first is near an edge in
/// one of two poses.
struct HeldBox {
  HeldBox()
      : object(geometry::load_known_object("box")), robot(hand, model, hand::resting_command()) {
    const Eigen::Vector3d half = object.bounds().sizes().cast<double>() / 2;
    for (int finger = 0; finger < 5; ++finger) {
      tactile::Contact contact;
      contact.finger = finger;
      contact.n = (finger == 0 ? -1 : 1) * Eigen::Vector3d::UnitZ();
      contact.p = {0, 0.01 * (finger - 2), (finger == 0 ? -1 : 1) * half.z()};
      contacts.push_back(contact);
    }
    contacts[1].p.x() = half.x() - 0.0005;
    for (const double shift : {0.0, 0.02}) {
      localization::Mode mode;
      mode.T_frame_object.translation().x() = shift;
      mode.weight = 0.5;
      posterior.modes.push_back(mode);
    }
  }
  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  geometry::ObjectModel object;
  hand::FakeHand hand;
  Executor robot;
  localization::Posterior posterior;
  std::vector<tactile::Contact> contacts;
};

TEST(MostTellingRoll, RollsAFingertipOverTheEdgeThatIsInQuestion) {
  const HeldBox held;
  const auto roll = most_informative_roll(held.robot, held.object, held.posterior, held.contacts);
  ASSERT_TRUE(roll);
  // Seen from the box the tip goes along +x: the box turns about -y, for the tip above it.
  EXPECT_NEAR(roll->turn.normalized().y(), -1, 1e-12);
  EXPECT_GT(roll->expected_gain.information, 2 * kNothing);
  EXPECT_LT(roll->expected_gain.information, std::log(2.0));
}

TEST(MostTellingRoll, TellsNothingAmidFaces) {
  HeldBox held;
  held.contacts[1].p.x() = 0;
  held.posterior.modes[1].T_frame_object.translation().x() = 0.005;
  const auto roll = most_informative_roll(held.robot, held.object, held.posterior, held.contacts);
  ASSERT_TRUE(roll);
  EXPECT_LT(roll->expected_gain.information, kNothing);
}

TEST(MostTellingRoll, RollsNothingThatIsNotHeldFirmly) {
  HeldBox held;
  held.contacts.resize(3);  // the thumb and two fingers
  EXPECT_FALSE(most_informative_roll(held.robot, held.object, held.posterior, held.contacts));
  held.contacts.clear();
  EXPECT_FALSE(most_informative_roll(held.robot, held.object, held.posterior, held.contacts));
}

}  // namespace
}  // namespace palpate::skills
