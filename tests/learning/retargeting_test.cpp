// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/retargeting.hpp"

#include <gtest/gtest.h>

#include "core/error_message.hpp"
#include "data.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/point_kinematics.hpp"
#include "palpate/learning/demonstrations/human_sequence.hpp"
#include "palpate/simulation/hand/mjcf_hand.hpp"

namespace palpate::learning {
namespace {

simulation::MjcfHand adroit() { return {asset("adroit_hand/adroit_relocate.xml"), "palm"}; }

std::unique_ptr<hand::PointKinematics> adroit_hand() {
  return std::make_unique<simulation::MjcfHand>(adroit());
}

/// Keypoints that the robot's own hand would have.
learning::HandKeypoints robot_keypoints(const Eigen::VectorXd& joints) {
  auto model = adroit();
  std::vector<hand::HandPoint> points = {model.point("palm")};
  const char* const names[5][4] = {{"thproximal", "thmiddle", "thdistal", "S_thtip"},
                                   {"ffknuckle", "ffmiddle", "ffdistal", "S_fftip"},
                                   {"mfknuckle", "mfmiddle", "mfdistal", "S_mftip"},
                                   {"rfknuckle", "rfmiddle", "rfdistal", "S_rftip"},
                                   {"lfknuckle", "lfmiddle", "lfdistal", "S_lftip"}};
  for (const auto& finger : names) {
    for (const char* name : finger) points.push_back(model.point(name));
  }
  return model.evaluate(joints, points).positions;
}

TEST(Retargeting, ARobotsOwnHandIsRepeated) {
  const auto model = adroit();
  Retargeter retargeter(adroit_hand(), adroit_points());
  RetargetedFrame frame;
  for (int i = 0; i < 40; ++i) {
    const double share = 0.3 + 0.2 * i / 40;
    const Eigen::VectorXd q = (1 - share) * model.lower() + share * model.upper();
    frame = retargeter.next(robot_keypoints(q));
  }
  EXPECT_LT(frame.tip_error, 0.003);
  EXPECT_LT(frame.middle_error, 0.003);
  EXPECT_LT(frame.T_world_root.translation().norm(), 0.01);
}

TEST(Retargeting, TurningTheWholeHandTurnsTheRoot) {
  const Eigen::VectorXd q = 0.6 * adroit().lower() + 0.4 * adroit().upper();
  Eigen::Isometry3d T(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()));
  T.translation() << 1, 2, 3;
  Retargeter here(adroit_hand(), adroit_points()), there(adroit_hand(), adroit_points());
  const auto keypoints = robot_keypoints(q);
  const auto a = here.next(keypoints);
  const auto b = there.next((T.linear() * keypoints).colwise() + T.translation());
  EXPECT_LT((a.joints - b.joints).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT((b.T_world_root.matrix() - (T * a.T_world_root).matrix()).norm(), 1e-3);
}

TEST(Retargeting, NoJointJumps) {
  const auto model = adroit();
  RetargetOptions options;
  options.alpha = 0;
  Retargeter retargeter(adroit_hand(), adroit_points(), options);
  const auto first = retargeter.next(robot_keypoints(0.9 * model.lower() + 0.1 * model.upper()));
  const auto second = retargeter.next(robot_keypoints(0.1 * model.lower() + 0.9 * model.upper()));
  EXPECT_LE((second.joints - first.joints).cwiseAbs().maxCoeff(), options.largest_step + 1e-12);
}

void expect_retargeted_within_the_targets(const std::filesystem::path& file) {
  const auto hand = filter_hand(read_keypoints(file), 30).hand;
  Retargeter retargeter(adroit_hand(), adroit_points());
  double tip = 0, middle = 0, jump = 0;
  Eigen::VectorXd before;
  for (const auto& keypoints : hand) {
    const auto frame = retargeter.next(keypoints);
    tip += frame.tip_error / static_cast<double>(hand.size());
    middle += frame.middle_error / static_cast<double>(hand.size());
    if (before.size() > 0) jump = std::max(jump, (frame.joints - before).cwiseAbs().maxCoeff());
    before = frame.joints;
  }
  EXPECT_LE(tip, 0.005);
  EXPECT_LE(middle, 0.007);
  EXPECT_LE(jump, 0.3);
}

TEST(Retargeting, AHumanSequenceIsMetWithinTheTargets) {
  for (const auto& file : made_up_and_real("hand_joints.csv", "human_relocate/hand_joints.csv")) {
    SCOPED_TRACE(file);
    expect_retargeted_within_the_targets(file);
  }
}

TEST(Retargeting, RefusesATipInTheMiddleOfItsLink) {
  auto points = adroit_points();
  points.tips[1] = "ffdistal";
  const auto message = error_message([&] { Retargeter(adroit_hand(), points); });
  EXPECT_NE(message.find("'ffdistal' lies at 0 %"), std::string::npos) << message;
  points.tips[1] = "S_sixth";
  EXPECT_NE(error_message([&] { Retargeter(adroit_hand(), points); }).find("S_sixth"),
            std::string::npos);
}

TEST(Retargeting, RefusesKeypointsThatAreNotFinite) {
  Retargeter retargeter(adroit_hand(), adroit_points());
  learning::HandKeypoints keypoints = robot_keypoints(0.5 * (adroit().lower() + adroit().upper()));
  keypoints(1, 7) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(retargeter.next(keypoints), BadInput);
}

}  // namespace
}  // namespace palpate::learning
