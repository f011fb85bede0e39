// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "palpate/core/file.hpp"
#include "palpate/simulation/hand/load_arm.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/arm_spec.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand_files.hpp"

namespace palpate::simulation {
namespace {

const std::string kServo =
    R"(<position kp="5000" kv="316" ctrlrange="-6.28 6.28" forcerange="-300 300"/>)";
const std::string kFlangeBody = R"(<body name="attachment" pos="0 0.1 0" euler="-1.5707963 0 0"/>)";
const std::string kStand = R"(<body name="stand">)";

std::string six_axes() {
  const auto root = std::filesystem::path(__FILE__).parent_path().parent_path().parent_path();
  return read_file(root / "examples/arms/six_axes.xml");
}

/// Files of arms, as long as it lives.
class ArmFiles {
 public:
  std::string write(const std::string& text) {
    const auto file = folder_.path() / ("arm_" + std::to_string(++count_) + ".xml");
    write_file_atomically(file, text);
    return file.string();
  }
  hand::ArmDescription load(const std::string& text, ArmOptions options = {}) {
    options.name = write(text);
    return *load_arm(options, load_hand("shadow"));
  }
  /// Why it is refused; empty if it is not.
  std::string refusal(const std::string& text) {
    return error_message([&] { (void)load(text); });
  }

 private:
  TemporaryFolder folder_;
  int count_ = 0;
};

hand::ArmVector bent(const hand::ArmDescription& arm) {
  hand::ArmVector joints(arm.joint_count());
  for (Eigen::Index i = 0; i < joints.size(); ++i) joints[i] = 0.3 + 0.1 * static_cast<double>(i);
  return joints;
}

/// Whether two arms have the same joints, which carry the mount in the same way.
void expect_same_arm(const hand::ArmDescription& a, const hand::ArmDescription& b) {
  ASSERT_EQ(a.joint_count(), b.joint_count());
  const hand::ArmVector joints = bent(a);
  EXPECT_TRUE(hand::mount_pose(a, joints).isApprox(hand::mount_pose(b, joints), 1e-9));
  EXPECT_LT((hand::mount_jacobian(a, joints) - hand::mount_jacobian(b, joints)).norm(), 1e-9);
}

/// The simulator has the hand where the description has it.
void expect_simulated_alike(ArmFiles& files, const std::string& text) {
  const hand::Description hand = load_hand("shadow");
  const hand::ArmDescription arm = files.load(text);
  const SpecHandle hand_spec = parse_hand(hand);
  const SpecHandle spec = arm_with_hand(arm, hand, *hand_spec);
  const ModelHandle model = compile(*spec);
  const DataHandle data = make_data(*model);
  const hand::ArmVector joints = bent(arm);
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const std::string& name = arm.joints[static_cast<std::size_t>(i)].name;
    data->qpos[model->jnt_qposadr[find_id(*model, mjOBJ_JOINT, kArmPrefix + name)]] = joints[i];
  }
  mj_kinematics(model.get(), data.get());
  const Eigen::Isometry3d expected = hand::mount_pose(arm, joints) * hand.file.T_mount_root;
  const int root = find_id(*model, mjOBJ_BODY, hand.file.root);
  EXPECT_TRUE(body_pose(*data, root).isApprox(expected, 1e-9));
}

/// As an MJCF that was compiled from a URDF: the stand is part of the world.
std::string without_stand() {
  std::string text = replaced(six_axes(), kStand, "");
  text = replaced(text, R"(<geom type="cylinder" size="0.08 0.05" pos="0 0 0.05"/>)", "");
  return replaced(text, "    </body>\n  </worldbody>", "  </worldbody>");
}

TEST(ArmFile, TheFirstBodyMayHaveAJoint) {
  ArmFiles files;
  const hand::ArmDescription arm = files.load(without_stand());
  EXPECT_EQ(arm.file.root, "shoulder");
  const hand::ArmJacobian J = hand::mount_jacobian(arm, bent(arm));
  for (Eigen::Index i = 0; i < J.cols(); ++i) EXPECT_GT(J.col(i).norm(), 0.5) << i;
  // The body's place in the file, 0.18 m up, is left out.
  hand::ArmDescription standing = files.load(six_axes());
  standing.T_world_stand.translation().z() -= 0.18;
  expect_same_arm(arm, standing);
  EXPECT_NE(files
                .refusal(replaced(without_stand(), R"(name="pan" axis)",
                                  R"(name="pan" type="slide" axis)"))
                .find("pan is a slide"),
            std::string::npos);
}

TEST(ArmFile, AnArmWhoseFirstBodyTurnsIsSimulatedAlike) {
  ArmFiles files;
  expect_simulated_alike(files, without_stand());
  expect_simulated_alike(files, replaced(without_stand(), R"(<joint name="pan")",
                                         R"(<joint name="pan" pos="0.05 0 0")"));
}

TEST(ArmFile, OtherBodiesOfTheWorldAreNotTheArms) {
  ArmFiles files;
  const hand::ArmDescription plain = files.load(six_axes());
  const std::string pedestal =
      R"(<body name="pedestal"><geom type="box" size=".1 .1 .1" pos="0 0 -.2"/></body>)";
  const std::string loose =
      R"(<body name="box"><freejoint name="loose"/><geom type="box" size=".1 .1 .1"/></body>)";
  const std::string before = replaced(six_axes(), kStand, pedestal + kStand);
  const std::string after = replaced(six_axes(), "  </worldbody>", loose + "</worldbody>");
  for (const std::string& text : {before, after, replaced(before, kStand, loose + kStand)}) {
    const hand::ArmDescription arm = files.load(text);
    EXPECT_EQ(arm.file.root, "stand");
    expect_same_arm(arm, plain);
    expect_simulated_alike(files, text);
  }
}

TEST(ArmFile, WhatMovesBeyondTheFlangeIsNamed) {
  ArmFiles files;
  const std::string finger =
      R"(<body name="attachment"><body name="finger"><joint name="grip" axis="1 0 0"/>)"
      R"(<geom size="0.01" fromto="0 0 0 0 0 0.1"/></body></body>)";
  const std::string why = files.refusal(replaced(six_axes(), kFlangeBody, finger));
  EXPECT_NE(why.find("joint grip does not move the flange"), std::string::npos) << why;
}

TEST(ArmFile, TheFlangeMayBeASite) {
  ArmFiles files;
  const hand::ArmDescription plain = files.load(six_axes());
  for (const char* name : {"attachment_site", "attachment"}) {
    const std::string site =
        std::string("<site name=\"") + name + R"(" pos="0 0.1 0" euler="-1.5707963 0 0"/>)";
    const std::string text = replaced(six_axes(), kFlangeBody, site);
    const hand::ArmDescription arm = files.load(text);
    EXPECT_EQ(arm.file.flange, "wrist_3");
    expect_same_arm(arm, plain);
    expect_simulated_alike(files, text);
  }
}

TEST(ArmFile, WithoutAFlangeItIsRefused) {
  ArmFiles files;
  const std::string why =
      files.refusal(replaced(six_axes(), R"(name="attachment")", R"(name="tool0")"));
  for (const char* words : {".xml", "attachment", "stand, shoulder", "tool0"}) {
    EXPECT_NE(why.find(words), std::string::npos) << why;
  }
}

TEST(ArmFile, StandsWhereTheOptionsSay) {
  ArmFiles files;
  const std::string displaced =
      replaced(six_axes(), kStand, R"(<body name="stand" pos="0.1 0.2 0.3">)");
  expect_same_arm(files.load(displaced), files.load(six_axes()));
  expect_simulated_alike(files, displaced);
}

TEST(ArmFile, ServosThatDoNotCommandTheAngleAreNamed) {
  ArmFiles files;
  const auto with = [&](const std::string& servo) {
    return files.refusal(replaced(six_axes(), kServo, servo));
  };
  for (const char* servo : {R"(<position gear="-1" kp="5000" kv="316" ctrlrange="-6.28 6.28"/>)",
                            R"(<position gear="2" kp="5000" kv="316" ctrlrange="-6.28 6.28"/>)"}) {
    const std::string why = with(servo);
    EXPECT_NE(why.find("joint pan"), std::string::npos) << why;
    EXPECT_NE(why.find("pan is no position servo with gear 1"), std::string::npos) << why;
  }
  const std::string general =
      R"(<general name="pan" joint="pan" gainprm="5000" biastype="affine" biasprm=")";
  const std::string pan = R"(<position name="pan" joint="pan"/>)";
  EXPECT_EQ(files.refusal(replaced(six_axes(), pan, general + R"(0 -5000 -316"/>)")), "");
  for (const char* bias : {R"(0 0 -316"/>)", R"(0 -4000 -316"/>)", R"(7 -5000 -316"/>)"}) {
    EXPECT_NE(files.refusal(replaced(six_axes(), pan, general + bias)), "") << bias;
  }
}

TEST(ArmFile, JointsKeepToTheRangeOfTheirServos) {
  ArmFiles files;
  const hand::ArmDescription narrow =
      files.load(replaced(six_axes(), R"(<position name="pan" joint="pan"/>)",
                          R"(<position name="pan" joint="pan" ctrlrange="-1 0.5"/>)"));
  EXPECT_EQ(narrow.joints[0].range.low, -1);
  EXPECT_EQ(narrow.joints[0].range.high, 0.5);
  EXPECT_EQ(narrow.joints[1].range.high, 6.28);
  // Files round the same limit in two ways: the joint's own is kept.
  const hand::ArmDescription rounded =
      files.load(replaced(six_axes(), R"(<position name="pan" joint="pan"/>)",
                          R"(<position name="pan" joint="pan" ctrlrange="-6.2799 6.2799"/>)"));
  EXPECT_EQ(rounded.joints[0].range.high, 6.28);
  const std::string why =
      files.refusal(replaced(six_axes(), R"(<position name="elbow" joint="elbow"/>)",
                             R"(<position name="elbow" joint="elbow" ctrlrange="4 5"/>)"));
  EXPECT_NE(why.find("joint elbow"), std::string::npos) << why;
}

TEST(ArmFile, TiedJointsAreRefused) {
  ArmFiles files;
  const std::string tie = R"(<equality><joint joint1="wrist_3" joint2="wrist_2"/></equality>)";
  const std::string why = files.refusal(replaced(six_axes(), "  <actuator>", tie + "<actuator>"));
  EXPECT_NE(why.find("joint wrist_2 is tied by an equality"), std::string::npos) << why;
}

TEST(ArmFile, WhatCannotBeReadIsCalledAnArm) {
  ArmFiles files;
  const std::string why = files.refusal("no XML");
  EXPECT_EQ(why.find("cannot read the arm "), 0u) << why;
}

}  // namespace
}  // namespace palpate::simulation
