// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/task_hand.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "skills/motion/lowest_part.hpp"

namespace palpate::relocate {
namespace {

class TaskHandTest : public testing::Test {
 protected:
  TaskHandTest() { task_.reset({.object = {-0.06, 0}}); }

  /// Goes there at a steady speed, and rests.
  void go(const hand::MountPosition& mount, double seconds) {
    const hand::HandCommand from = hand_.here();
    const int ticks = hand::whole_ticks(seconds);
    for (int i = 1; i <= ticks + 50; ++i) {
      const double share = std::min(1.0, static_cast<double>(i) / ticks);
      hand_.step({from.positions, hand::between(from.mount, mount, share)});
    }
  }

  RelocateModel model_{relocate_primitive_mug()};
  RelocateTask task_{model_};
  RelocateTouch touch_{model_, {0, 0, 0, 0, 0, 0}, 1};
  TaskHand hand_{task_, model_, touch_};
};

TEST_F(TaskHandTest, StaysWhereItStarts) {
  const hand::HandCommand start = hand_.here();
  EXPECT_LT((start.mount.xyz - Eigen::Vector3d(0, -0.7, 0.2)).norm(), 1e-9);
  EXPECT_LT(start.mount.ypr.norm(), 1e-9);
  hand::HandReading reading;
  for (int i = 0; i < 100; ++i) reading = hand_.step(start);
  EXPECT_EQ(hand_.steps(), 100);
  EXPECT_NEAR(reading.time, 1.0, 1e-9);
  EXPECT_LT((reading.mount.xyz - start.mount.xyz).norm(), 0.0105);  // the lift's stop is soft
  EXPECT_LT((reading.mount.xyz - start.mount.xyz).head<2>().norm(), 1e-3);
  EXPECT_LT((reading.joints - touch_.read(task_, 0).joints).norm(), 1e-9);
  EXPECT_LT(reading.mount_force.norm(), 1e-9);  // nothing touches it
}

TEST_F(TaskHandTest, GoesWhereItIsCommanded) {
  hand::MountPosition there = hand_.here().mount;
  there.xyz += Eigen::Vector3d(0.1, 0.15, 0.1);
  there.ypr << 0.4, 0.1, -0.3;
  go(there, 1.0);
  const hand::MountPosition here = hand_.here().mount;
  EXPECT_LT((here.xyz - there.xyz).norm(), 1e-3);
  EXPECT_LT((here.ypr - there.ypr).norm(), 3e-3);
}

TEST_F(TaskHandTest, NamesTheJointOfTheArmThatIsOutOfRange) {
  hand::MountPosition there = hand_.here().mount;
  EXPECT_TRUE(hand_.check_path({&there, 1}).obstacle.empty());
  const std::array path = {there, hand::MountPosition{there.xyz + Eigen::Vector3d(0, 0, 0.3), {}}};
  const auto high = hand_.check_path(path);
  EXPECT_EQ(high.obstacle, "ARTy would be at 0.3 m, its range is 0 to 0.2");
  EXPECT_EQ(high.feasible, 1u);
  there.ypr[0] = 1.0;
  EXPECT_NE(hand_.check_path({&there, 1}).obstacle.find("ARRy"), std::string::npos);
}

// Nothing of the hand but the finger that points is near what its tip touches.
TEST_F(TaskHandTest, PointsWithAFingerBelowAllElse) {
  const hand::Description& hand = touch_.hand_model();
  const hand::PointingHand& pointing = hand.postures.pointing.at(0);
  const int tip = hand.fingers[static_cast<std::size_t>(pointing.finger)].link;
  const double lowest = skills::lowest_part(hand, pointing.positions, pointing.attitude);
  const auto of_others = [&](int link) {
    int own = tip;  // and then the finger's other links, up to the palm
    while (own != hand.palm && own != link) own = hand.links[static_cast<std::size_t>(own)].parent;
    return own != link || link == hand.palm;
  };
  const double others = skills::lowest_part(hand, pointing.positions, pointing.attitude, of_others);
  EXPECT_GT(others - lowest, 0.03);
}

// The table pushes up what presses on it, and the arm bears that downwards.
TEST_F(TaskHandTest, SensesTheTableByItsMount) {
  hand::MountPosition low = hand_.here().mount;
  low.ypr[2] = -0.7;
  low.xyz.z() = 0.2;
  go(low, 2.0);
  const auto reading = hand_.sense();
  ASSERT_TRUE(reading);
  EXPECT_LT(reading->mount_force.z(), -1.0);
}

}  // namespace
}  // namespace palpate::relocate
