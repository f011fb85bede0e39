// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/online_tracker.hpp"

#include <gtest/gtest.h>

#include "estimation/box_in_hand.hpp"
#include "palpate/core/error.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::estimation {
namespace {

class OnlineTrackerTest : public BoxInHandTest {
 protected:
  OnlineTrackerTest() { options.estimate = false; }

  OnlineTrackerOptions options;
};

TEST_F(OnlineTrackerTest, StaysUntilTheHandLiftsWhatItTouches) {
  OnlineTracker tracker(object, hand, at({0.1, 0, 0.05}), options, 1);
  tracker.update(reading({0, 0, 0.3}, false));
  tracker.update(reading({0.02, 0, 0.2}, false));
  tracker.update(reading({0.04, 0, 0.2}, true));  // pushes perhaps, but has not risen
  EXPECT_EQ(tracker.T_world_object().translation(), Eigen::Vector3d(0.1, 0, 0.05));
  tracker.update(reading({0.04, 0, 0.25}, false));  // rises with nothing
  EXPECT_EQ(tracker.T_world_object().translation(), Eigen::Vector3d(0.1, 0, 0.05));
  tracker.update(reading({0.04, 0, 0.26}, true));
  tracker.update(reading({0.05, 0.02, 0.30}, true));
  EXPECT_LT((tracker.T_world_object().translation() - Eigen::Vector3d(0.11, 0.02, 0.10)).norm(),
            1e-12);
  tracker.update(reading({0.2, 0.1, 0.5}, false));  // let go
  EXPECT_LT((tracker.T_world_object().translation() - Eigen::Vector3d(0.11, 0.02, 0.10)).norm(),
            1e-12);
  EXPECT_EQ(tracker.estimates(), 0);
}

TEST_F(OnlineTrackerTest, AnEstimateIsThereOnePeriodLater) {
  options.estimate = true;
  options.fingers = 1;
  options.period = 0.05;
  options.estimation.free_space = false;
  options.rotation_sigma = 0.02;
  options.translation_sigma = 0.004;
  OnlineTracker tracker(object, hand, at({0, 0, 0.05}), options, 1);
  // The fingertip touches 4 mm beside where the box is believed to be: it must have been moved.
  hand::HandReading beside = reading({0, 0, 0}, true);
  const Eigen::Isometry3d T_mount_tip =
      hand::forward_kinematics(hand, beside.joints)[static_cast<std::size_t>(hand.fingers[1].link)];
  const Eigen::Vector3d n = T_mount_tip.linear().transpose() * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d p = hand.fingers[1].tip.b - hand.fingers[1].tip.radius * n;
  beside.mount.xyz = Eigen::Vector3d(0.029, 0, 0.05) - T_mount_tip * p;
  beside.contacts[1] = {{.p = p, .n = n, .f = -2 * n}};
  for (int i = 0; i < 5; ++i) {
    tracker.update(beside);
    EXPECT_EQ(tracker.T_world_object().translation(), Eigen::Vector3d(0, 0, 0.05)) << i;
  }
  tracker.update(beside);
  EXPECT_GT(tracker.T_world_object().translation().x(), 0.001);
  EXPECT_EQ(tracker.estimates(), 2);
}

TEST_F(OnlineTrackerTest, NeedsAPose) {
  EXPECT_THROW(OnlineTracker(object, hand, {}, options, 1), BadInput);
}

}  // namespace
}  // namespace palpate::estimation
