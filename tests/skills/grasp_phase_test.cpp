// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/grasp_phase.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::skills {
namespace {

constexpr double kTouch = 0.5;  // rad of FFJ3 at which all fingers touch
constexpr double kPress = 0.3;  // N of a fingertip

/// A hand whose fingers all touch once they have closed: from both sides, or from one as if the
/// thumb had missed the object.
struct ClosingHand {
  explicit ClosingHand(int bad_closings)
      : bad(bad_closings), hand([this](hand::HandReading& reading) { sense(reading); }) {
    auto& box = object.object();
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = box.stable_poses[0].R_table_object;
    T.translation().z() = box.stable_poses[0].height;
    localization::Mode mode;
    mode.T_frame_object = T;
    mode.weight = 1;
    state.resting.emplace();
    state.resting->modes.push_back(mode);
    robot.wait(hand::kTick);
  }

  void sense(hand::HandReading& reading) {
    const bool closed = reading.joints[hand::shadow_hand().joint("FFJ3")] > kTouch;
    closings += closed && !was_closed;
    was_closed = closed;
    if (!closed) return;
    const auto T = hand::forward_kinematics(model, reading.joints);
    for (std::size_t finger = 0; finger < hand::kShadowFingers; ++finger) {
      const Eigen::Isometry3d T_link_mount =
          T[static_cast<std::size_t>(model.fingers[finger].link)].inverse();
      const double side = finger == 0 && closings > bad ? -1 : 1;
      const Eigen::Vector3d p(0.02 * (static_cast<double>(finger) - 2.5), side * 0.02, 0.1);
      const Eigen::Vector3d n = T_link_mount.linear() * Eigen::Vector3d(0, side, 0);
      const Eigen::Vector3d middle(finger == 0 ? 0 : p.x(), p.y(), p.z());
      reading.contacts[finger] = {{T_link_mount * middle, n, -kPress * n}};
    }
  }

  PhaseReport grasp() {
    GraspPhase phase(options, object);
    return run_phase(phase, robot, state);
  }

  int bad = 0, closings = 0;
  bool was_closed = false;
  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  geometry::ObjectModel object{geometry::load_known_object("box")};
  GraspOptions options;
  PickState state;
  hand::FakeHand hand;
  Executor robot{hand, model,   evaluation::waiting_command(model),
                 {},   nullptr, {{.tip_reach = 1}, {}, {}}};
};

TEST(GraspPhase, PressesWhereTheForcesBalance) {
  ClosingHand scene(0);
  const auto report = scene.grasp();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_EQ(scene.closings, 1);
  EXPECT_EQ(scene.state.tried_yaws, std::vector{scene.state.yaw});
  EXPECT_EQ(scene.robot.log().all(estimation::TouchEvent::closed).size(), 1u);
}

TEST(GraspPhase, ClosesAgainFromAnotherSideWhereTheyDoNot) {
  ClosingHand scene(1);
  const auto report = scene.grasp();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_EQ(scene.closings, 2);
  ClosingHand balanced(0);
  balanced.grasp();
  EXPECT_NE(scene.state.yaw, balanced.state.yaw);
  EXPECT_EQ(scene.state.tried_yaws, std::vector{scene.state.yaw});
  EXPECT_EQ(scene.robot.log().all(estimation::TouchEvent::closed).size(),
            1u);  // only the hold that stays
  EXPECT_NE(report.outcome.find("closing 2"), std::string::npos) << report.outcome;
}

TEST(GraspPhase, ClosesNoMoreOftenThanItMay) {
  ClosingHand scene(100);
  scene.options.closings = 2;
  scene.grasp();
  EXPECT_EQ(scene.closings, 2);
}

}  // namespace
}  // namespace palpate::skills
