// SPDX-License-Identifier: Apache-2.0
#include "estimation/in_hand_motion.hpp"

#include <gtest/gtest.h>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kReadings = 61;

/// The wrist bends, and with it all fingers, which touch with places that wander along their tips.
struct BendingWrist {
  explicit BendingWrist(int fingers)
      : hand(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"))) {
    for (std::size_t i = 0; i < kReadings; ++i) {
      hand::HandReading reading = hand::resting_reading();
      reading.time = static_cast<double>(i) * hand::kTick;
      reading.joints[hand::shadow_hand().joint("WRJ1")] = 0.005 * static_cast<double>(i);
      for (int finger = 0; finger < fingers; ++finger) {
        const double along = 0.01 + 1e-4 * static_cast<double>(i);
        reading.contacts[static_cast<std::size_t>(finger)] = {
            {{0, 0.007, along}, {0, -1, 0}, {0, 1, 0}}};
      }
      log.readings.push_back(reading);
    }
  }
  Eigen::Isometry3d palm(std::size_t reading) const {
    const auto T = hand::forward_kinematics(hand, log.readings[reading].joints);
    return T[static_cast<std::size_t>(hand.palm)];
  }
  Eigen::Isometry3d carried(std::size_t first, std::size_t last,
                            const Fingers& ignored = {}) const {
    return in_hand_motion(hand, log, first, last, {}, ignored).T;
  }
  /// Of an object that hangs in the hand.
  std::vector<localization::FreeAxis> loose() {
    log.moments = {{TouchEvent::held, 5}};
    return in_hand_motion(hand, log, 10, 50, {}).loose;
  }
  hand::Description hand;
  EventLog log;
};

TEST(CarriedMotion, IsThatOfTheHandThatHoldsWhereverItsContactsWander) {
  const BendingWrist scene(5);
  // Windows of ten readings lag behind alike at both ends.
  const Eigen::Isometry3d motion = scene.palm(50) * scene.palm(10).inverse();
  const Eigen::Isometry3d carried = scene.carried(10, 50);
  EXPECT_LT(rotation_distance(carried.linear(), motion.linear()), 0.002);
  EXPECT_GT(rotation_distance(carried.linear(), Eigen::Matrix3d::Identity()), 0.19);
  const Eigen::Vector3d held = scene.palm(10) * Eigen::Vector3d(0, 0, 0.1);
  EXPECT_LT((carried * held - motion * held).norm(), 0.01 * (motion * held - held).norm() + 0.002);
}

TEST(CarriedMotion, NamesTheAxisAboutWhichAnObjectSwingsInTwoFingertips) {
  BendingWrist scene(2);
  EXPECT_TRUE(in_hand_motion(scene.hand, scene.log, 10, 50, {}).loose.empty()) << "it stands";
  const auto axes = scene.loose();
  ASSERT_EQ(axes.size(), 1u);
  const auto& reading = scene.log.readings[50];
  const auto T = hand::forward_kinematics(scene.hand, reading.joints);
  std::vector<Eigen::Vector3d> contacts;
  for (std::size_t finger = 0; finger < 2; ++finger) {
    const auto link = static_cast<std::size_t>(scene.hand.fingers[finger].link);
    contacts.push_back(T[link] * reading.contacts[finger].front().p);
  }
  const Eigen::Vector3d along = (contacts[1] - contacts[0]).normalized();
  EXPECT_NEAR(std::abs(axes[0].direction.dot(along)), 1, 0.01);
  EXPECT_LT((axes[0].point - contacts[0]).cross(along).norm(), 0.005) << "on the line";
}

TEST(CarriedMotion, ThreeFingertipsLetNothingSwingAndOneAllWays) {
  EXPECT_TRUE(BendingWrist(3).loose().empty());
  EXPECT_EQ(BendingWrist(1).loose().size(), 3u);
}

TEST(CarriedMotion, TwoContactsTellOnlyTheWay) {
  const BendingWrist scene(2);
  EXPECT_TRUE(scene.carried(10, 50).linear().isIdentity(1e-12));
  EXPECT_GT(scene.carried(10, 50).translation().norm(), 0.01);
}

TEST(CarriedMotion, NoneWithoutContactsOrTime) {
  EXPECT_TRUE(BendingWrist(0).carried(10, 50).isApprox(Eigen::Isometry3d::Identity()));
  const BendingWrist scene(5);
  EXPECT_TRUE(scene.carried(30, 30).isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(scene.carried(10, 50, {true, true, true, true, true})
                  .isApprox(Eigen::Isometry3d::Identity()));
}

}  // namespace
}  // namespace palpate::estimation
