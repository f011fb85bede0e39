// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/human_sequence.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "data.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::learning {
namespace {

std::vector<learning::HandKeypoints> moving_hand(int frames) {
  std::vector<learning::HandKeypoints> result;
  for (int i = 0; i < frames; ++i) {
    learning::HumanJoints q = learning::HumanJoints::Constant(0.2);
    q[learning::human_joint_index("FF3")] = 0.5 + 0.01 * i;
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation().x() = 0.002 * i;
    result.push_back(learning::human_keypoints(q, {}, T));
  }
  return result;
}

TEST(HumanSequence, FillsGapsAndReplacesWrongJoints) {
  const auto truth = moving_hand(40);
  auto seen = truth;
  seen[7].col(8).setConstant(std::numeric_limits<double>::quiet_NaN());
  seen[8].col(8).setConstant(std::numeric_limits<double>::quiet_NaN());
  seen[20].col(12) += Eigen::Vector3d(0, 0.2, 0);
  seen[0].col(4).setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto filtered = filter_hand(seen, 30, {0, 0.25, 0});
  EXPECT_EQ(filtered.replaced, 4);
  EXPECT_LT((filtered.hand[7] - truth[7]).norm(), 1e-3);
  EXPECT_LT((filtered.hand[20] - truth[20]).norm(), 1e-3);
  EXPECT_LT((filtered.hand[0] - truth[0]).norm(), 0.01);
}

TEST(HumanSequence, SmoothsNoise) {
  RandomStream random(9);
  const auto truth = moving_hand(60);
  auto seen = truth;
  for (auto& frame : seen) {
    for (double& value : frame.reshaped()) value += 0.002 * random.normal();
  }
  const auto filtered = filter_hand(seen, 60, {0, 0.5, 0.04}).hand;
  double before = 0, after = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    before += (seen[i] - truth[i]).squaredNorm();
    after += (filtered[i] - truth[i]).squaredNorm();
  }
  EXPECT_LT(after, 0.6 * before);
}

TEST(HumanSequence, ReadsAHumanSequence) {
  for (const auto& file : made_up_and_real("hand_joints.csv", "human_relocate/hand_joints.csv")) {
    EXPECT_EQ(read_keypoints(file).size(), 122U) << file;
  }
  for (const auto& file : made_up_and_real("object_pose.csv", "human_relocate/object_pose.csv")) {
    EXPECT_EQ(read_poses(file).size(), 123U) << file;
  }
}

TEST(HumanSequence, FillsTheGapsOfATracker) {
  const auto hand = filter_hand(read_keypoints(made_up_data("hand_joints.csv")), 30);
  EXPECT_EQ(hand.hand.size(), 112U);
  EXPECT_EQ(hand.replaced, 3);
  for (const auto& frame : hand.hand) EXPECT_TRUE(frame.allFinite());
}

TEST(HumanSequence, RejectsBadFiles) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "hand.csv";
  std::string header = "frame";
  for (int joint = 0; joint < 21; ++joint) {
    for (const char axis : {'x', 'y', 'z'}) {
      header += ",j" + std::to_string(joint) + "_" + std::string(1, axis);
    }
  }
  std::string row = "0";
  for (int i = 0; i < 63; ++i) row += ",0.1";
  const auto message = [&](const std::string& text) {
    write_file_atomically(path, text);
    return error_message([&] { read_keypoints(path); });
  };
  EXPECT_EQ(message(header + "\n" + row + "\n"), "");
  EXPECT_NE(message("a,b\n").find("hand.csv:1"), std::string::npos);
  EXPECT_NE(message(header + "\n").find("no frame"), std::string::npos);
  EXPECT_NE(message(header + "\n" + row + ",1\n").find("hand.csv:2: 65 values"), std::string::npos);
  EXPECT_NE(message(header + "\n" + row + "\n1" + row.substr(1, row.size() - 4) + "abc\n")
                .find("hand.csv:3: 'abc'"),
            std::string::npos);
  const auto poses = folder.path() / "pose.csv";
  write_file_atomically(poses,
                        "frame,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n"
                        "0,1,0,0,0,0,1,0,0,0,0,2,0\n");
  EXPECT_NE(error_message([&] { read_poses(poses); }).find("pose.csv:2: not a rotation"),
            std::string::npos);
}

TEST(HumanSequence, FramesFollowOneAnother) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "pose.csv";
  const auto message = [&](const std::vector<std::string>& frames) {
    std::string text = "frame,T00,T01,T02,T03,T10,T11,T12,T13,T20,T21,T22,T23\n";
    for (const auto& frame : frames) text += frame + ",1,0,0,0,0,1,0,0,0,0,1,0\n";
    write_file_atomically(path, text);
    return error_message([&] { read_poses(path); });
  };
  EXPECT_EQ(message({"7", "8", "9"}), "");
  EXPECT_NE(message({"2", "1", "0"}).find("pose.csv:3: frame 1 follows frame 2"),
            std::string::npos);
  EXPECT_NE(message({"0", "1", "5"}).find("pose.csv:4: frame 5 follows frame 1"),
            std::string::npos);
  EXPECT_NE(message({"3", "3"}).find("frame 3 follows frame 3"), std::string::npos);
  EXPECT_NE(message({"0.5"}).find("no whole number"), std::string::npos);
}

TEST(HumanSequence, RejectsSequencesWithoutWhatItNeeds) {
  EXPECT_THROW(filter_hand(moving_hand(5), 30, {10, 0.25, 0.02}), BadInput);
  EXPECT_THROW(filter_hand(moving_hand(5), 0, {0, 0.25, 0.02}), BadInput);
  auto blind = moving_hand(5);
  for (auto& frame : blind) frame.col(3).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(error_message([&] {
              filter_hand(blind, 30, {0, 0.25, 0.02});
            }).find("joint 3"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::learning
