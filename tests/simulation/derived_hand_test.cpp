// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "described_hands.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::simulation {
namespace {

TEST(Closing, OfSymmetricRangesIsTowardsTheOtherFingers) {
  const auto symmetric = [](std::string text, const std::vector<std::string>& joints) {
    for (const std::string& name : joints) {
      const auto at = text.find("range=\"", text.find("joint name=\"" + name + "\"")) + 7;
      text.replace(at, 1, fmt::format("-{}", text.substr(at + 2, 3)));
    }
    return described("symmetric.xml", text);
  };
  const std::vector<std::string> all = {"index_1", "index_2", "ring_1",
                                        "ring_2",  "thumb_1", "thumb_2"};
  for (const auto& joints : {std::vector<std::string>{"thumb_1", "thumb_2"}, all}) {
    const auto result = symmetric(kHandMjcf, joints);
    for (const std::string& name : all) EXPECT_EQ(actuator(result, name).closing, 1) << name;
    EXPECT_TRUE(says(result.guesses, "have symmetric ranges"));
  }
  std::string mirrored = kHandMjcf;  // a finger whose joints turn the other way
  for (const std::string name : {"ring_1", "ring_2"}) {
    const std::string joint = "joint name=\"" + name + "\" axis=\"0 ";
    mirrored = replaced(mirrored, joint + "1", joint + "-1");
  }
  const auto result = symmetric(mirrored, all);
  for (const std::string& name : all) {
    EXPECT_EQ(actuator(result, name).closing, name.starts_with("ring") ? -1 : 1) << name;
  }
}

TEST(Closing, OfAFollowerIsThatOfItsLeader) {
  HandNotes notes;
  notes.closing = "index_2,ring_2,thumb_2";
  EXPECT_NE(why_not("<equality><joint joint1='index_2' joint2='index_1'/></equality>", notes)
                .find("joint index_2 follows index_1; name index_1"),
            std::string::npos);
}

/// The hand of two fingers and a thumb, drawn straight where its first joints are at their ends.
std::string closed_at_zero(const std::string& range = "0 1.6") {
  std::string text = kHandMjcf;
  for (const std::string name : {"index_1", "ring_1", "thumb_1"}) {
    const std::string joint = "<joint name=\"" + name + "\" axis=";
    text = replaced(text, joint + "\"0 1 0\" range=\"0 1.6\"",
                    joint + "\"0 -1 0\" ref=\"1.6\" range=\"" + range + "\"");
  }
  return text;
}

TEST(Closing, TowardsZeroInAFileWhoseHandIsClosedThere) {
  const auto plain = described("plain.xml", kHandMjcf);
  for (const std::string range : {"0 1.6", "-0.03 1.6"}) {
    const auto result = described("closed_at_zero.xml", closed_at_zero(range));
    EXPECT_TRUE(says(result.guesses, "0 is the closed hand"));
    for (const std::string name : {"index_1", "ring_1", "thumb_1"}) {
      EXPECT_LT(actuator(result, name).closing, 0) << name;
      EXPECT_EQ(hand::straight_command(actuator(result, name)), 1.6) << name;
      EXPECT_LE(hand::closed_command(actuator(result, name)), 0) << name;
    }
    for (const std::string name : {"index_2", "ring_2", "thumb_2"}) {
      EXPECT_GT(actuator(result, name).closing, 0) << name;
    }
    EXPECT_EQ(result.hand.thumb, plain.hand.thumb);
    const Eigen::Matrix3d R = plain.hand.file.T_mount_root.linear();
    EXPECT_NEAR((result.hand.file.T_mount_root.linear() - R).norm(), 0, 0.1) << range;
  }
}

std::string finger_of_gripper(const std::string& name, double x, const std::string& axis) {
  return fmt::format(
      "<body name='{0}_base' pos='{1} 0 0'><joint name='{0}_1' axis='{2}' range='0 1.57'/>"
      "<geom type='capsule' size='0.008' fromto='0 0 -0.01 0 0 -0.05'/>"
      "<body name='{0}_tip' pos='0 0 -0.06'><joint name='{0}_2' axis='{2}' range='0 1.57'/>"
      "<geom type='capsule' size='0.008' fromto='0 0 -0.01 0 0 -0.05'/></body></body>",
      name, x, axis);
}

/// Its fingers can swing past one another.
TEST(Closing, OfAGripperIsNotReversed) {
  for (const double apart : {0.03, 0.05, 0.09, 0.12}) {
    const auto result = described("gripper.xml",
                                  "<mujoco><compiler angle='radian'/><worldbody><body name='palm'>"
                                  "<geom type='box' size='0.07 0.03 0.005' pos='0 0 0.02'/>" +
                                      finger_of_gripper("left", -apart / 2, "0 -1 0") +
                                      finger_of_gripper("right", apart / 2, "0 1 0") +
                                      "</body></worldbody></mujoco>");
    for (const std::string name : {"left_1", "left_2", "right_1", "right_2"}) {
      EXPECT_GT(actuator(result, name).closing, 0) << name << " " << apart;
    }
  }
}

/// The index and the ring finger on a part of the palm.
std::string knuckles(const std::string& joint) {
  const auto text = replaced(kHandMjcf, "<body name=\"index_base\"",
                             "<body name=\"knuckles\">" + joint +
                                 "<geom type=\"box\" size=\"0.005 0.03 0.005\" pos=\"0.03 0 0\"/>"
                                 "<body name=\"index_base\"");
  return replaced(text, "<body name=\"thumb_base\"", "</body><body name=\"thumb_base\"");
}

TEST(Fingers, APalmInTwoPartsLosesNone) {
  for (const std::string joint : {"", "<joint name=\"fold\" axis=\"1 0 0\" range=\"0 0.5\"/>"}) {
    const auto result = described("knuckles.xml", knuckles(joint));
    ASSERT_EQ(result.hand.finger_count(), 3);
    EXPECT_EQ(result.hand.fingers[1].name, "ring");
    EXPECT_EQ(result.hand.thumb, 2);
    EXPECT_EQ(actuator(result, "ring_1").finger, 1);
    if (!joint.empty()) {
      EXPECT_EQ(actuator(result, "fold").finger, -1);
    }
    EXPECT_FALSE(reports(result, "belong to no finger"));
  }
}

TEST(Fingers, SaysWhichJointsMoveNone) {
  const auto text = replaced(kHandMjcf, "<body name=\"index_base\"",
                             "<body name=\"ear\"><joint name=\"ear_1\" range=\"0 1\"/>"
                             "<geom size=\"0.01\" contype=\"0\" conaffinity=\"0\"/></body>"
                             "<body name=\"index_base\"");
  EXPECT_TRUE(reports(described("ear.xml", text), "joints ear_1 belong to no finger"));
}

TEST(Fingers, ReportsJointsThatCarrySeveral) {
  EXPECT_TRUE(says(
      described("knuckles.xml", knuckles("<joint name=\"fold\" axis=\"1 0 0\" range=\"0 0.5\"/>"))
          .guesses,
      "joints fold carry several fingers and are held"));
}

TEST(Fingers, ReportsJointsBeyondTheTipsThatTheUserNames) {
  HandNotes notes;
  notes.tips = "index_base,ring_tip,thumb_tip";
  EXPECT_TRUE(says(hand_with("", notes).guesses, "joints index_2 are beyond the fingertips"));
}

TEST(Fingers, ReportsShapesOutsideAFingertip) {
  const std::string capsule =
      "<geom type=\"capsule\" size=\"0.008\" fromto=\"0.008 0 0 0.03 0 0\"/>";
  const auto with_nail = [&](const std::string& pos) {
    return described("nail.xml", replaced(kHandMjcf, capsule,
                                          capsule +
                                              "<geom type=\"box\" size=\"0.004 0.006 0.001\" "
                                              "pos=\"" +
                                              pos + "\"/>"));
  };
  const std::string said = "beyond the fingertip's surface meet nothing: index_tip (";
  EXPECT_TRUE(says(with_nail("0.03 0 0.014").guesses, said));
  EXPECT_FALSE(says(with_nail("0.025 0 0.003").guesses, said));
  const auto tip = with_nail("0.03 0 0.01").hand.fingers[0].tip;  // it reaches farther, a little
  EXPECT_EQ(tip.radius, 0.008);
}

TEST(Root, AnotherHandOfTheFileIsReported) {
  std::string other = kHandMjcf.substr(kHandMjcf.find("<body name=\"palm\">"));
  other = other.substr(0, other.find("</worldbody>"));
  for (std::size_t at = 0; (at = other.find("name=\"", at)) != std::string::npos; at += 8) {
    other.insert(at + 6, "left_");
  }
  const auto text = replaced(kHandMjcf, "</worldbody>", other + "</worldbody>");
  EXPECT_TRUE(reports(described("two.xml", text), "another body with 6 hinges, left_palm"));
  HandNotes notes;
  notes.root = "left_palm";
  EXPECT_TRUE(described("two.xml", text, notes).problems.empty());
}

TEST(Fingers, OneDriveForAllIsRefused) {
  const std::string ring =
      "<joint joint1='ring_1' joint2='index_1'/><joint joint1='ring_2' joint2='index_1'/>";
  const auto two =
      replaced(kHandMjcf, "</worldbody>", "</worldbody><equality>" + ring + "</equality>");
  EXPECT_TRUE(
      reports(described("two.xml", two), "finger ring is moved only by the drive of finger index"));
  EXPECT_NE(why_not("<equality>" + ring +
                    "<joint joint1='index_2' joint2='index_1'/>"
                    "<joint joint1='thumb_1' joint2='index_1'/>"
                    "<joint joint1='thumb_2' joint2='index_1'/></equality>")
                .find("a hand with one drive for all its fingers is not supported"),
            std::string::npos);
}

TEST(Fingers, TipsThatAreNoneAreRefused) {
  const auto why = [](const char* tips) {
    HandNotes notes;
    notes.tips = tips;
    return why_not("", notes);
  };
  EXPECT_NE(why("index_tip,index_tip,thumb_tip").find("tips names index_tip twice"),
            std::string::npos);
  EXPECT_NE(why("palm,index_tip").find("no joint moves palm"), std::string::npos);
  EXPECT_NE(why("index_tip,index_base").find("are of one finger"), std::string::npos);
}

/// Two fingers that point up and bend inwards, far beyond the middle.
std::string gripper() {
  std::string text =
      "<mujoco><worldbody><body name='base'><geom type='cylinder' size='0.04 0.03' "
      "pos='0 0 -0.03'/>";
  for (const auto& [name, x, turn] :
       {std::tuple("left", 0.045, 180), std::tuple("right", -0.045, 0)}) {
    text += fmt::format(
        "<body name='{0}_1' pos='{1} 0 0' euler='0 0 {2}'><joint name='{0}_a' axis='0 1 0' "
        "range='-20 70'/><geom type='capsule' size='0.008' fromto='0 0 0.01 0 0 0.05'/>"
        "<body name='{0}_2' pos='0 0 0.062'><joint name='{0}_b' axis='0 1 0' range='-20 70'/>"
        "<geom type='capsule' size='0.008' fromto='0 0 0.008 0 0 0.034'/></body></body>",
        name, x, turn);
  }
  return text + "</body></worldbody></mujoco>";
}

TEST(Mount, FingersThatBendInwardsPointDown) {
  const auto result = described("gripper.xml", gripper());
  EXPECT_TRUE(says(result.guesses, "the fingers point down"));
  const hand::Description& hand = result.hand;
  const auto T = hand::forward_kinematics(hand, hand::JointVector::Zero(hand.joint_count()));
  for (const hand::Finger& finger : hand.fingers) {
    const double tip = (T[static_cast<std::size_t>(finger.link)] * finger.tip.b).z();
    EXPECT_NEAR(T[static_cast<std::size_t>(hand.palm)].translation().z() - tip, 0.096, 0.005);
  }
}

TEST(Mount, AGivenPoseNeedsNoMoreThanItself) {
  HandNotes notes;
  notes.mount_xyz.z() = 0.09;
  const auto result = hand_with("", notes);
  EXPECT_EQ(result.hand.file.T_mount_root.translation(), Eigen::Vector3d(0, 0, 0.09));
}

TEST(Mount, OneThatIsFarFromTheDerivedIsReported) {
  const Eigen::Isometry3d derived = hand_with("").hand.file.T_mount_root;
  HandNotes notes;
  notes.mount_xyz = derived.translation();
  const Eigen::Vector3d ypr = derived.linear().eulerAngles(2, 1, 0) * 180 / std::numbers::pi;
  notes.mount_rpy = ypr.reverse();
  EXPECT_TRUE(hand_with("", notes).problems.empty());
  HandNotes turned = notes, away = notes;
  turned.mount_rpy.x() += 90;
  EXPECT_TRUE(reports(hand_with("", turned), "the given mount is 90 deg"));
  away.mount_xyz.z() += 0.3;
  EXPECT_TRUE(reports(hand_with("", away), "and 300 mm from the one that is derived"));
}

TEST(FingerNames, AreCutAtSeparatorsOnly) {
  const auto result = described("gripper.xml", gripper());
  EXPECT_EQ(result.hand.fingers[0].name, "left");
  EXPECT_EQ(result.hand.fingers[1].name, "right");
}

TEST(Followers, ALeaderGoesNoFartherThanTheyCan) {
  const auto result = hand_with(
      "<equality><joint joint1='index_2' joint2='index_1' polycoef='0 2 0 0 0'/></equality>");
  EXPECT_NEAR(actuator(result, "index_1").command.high, 0.7, 1e-12);
  EXPECT_TRUE(says(result.guesses, "index_1 moves from 0.00 to 0.70 rad"));
}

TEST(Followers, ALockedJointIsNotFree) {
  const auto result =
      hand_with("<equality><joint joint1='thumb_1' polycoef='0.3 0 0 0 0'/></equality>");
  const hand::Description& hand = result.hand;
  ASSERT_EQ(hand.actuator_count(), 5);
  for (const double position : {0.0, 1.0}) {
    const auto joints =
        hand::joints_in_free_flexion(hand, hand::ActuatorVector::Constant(5, position));
    EXPECT_EQ(joints[hand.joint("thumb_1")], 0.3);
  }
  EXPECT_TRUE(says(result.guesses, "joint thumb_1 is locked at 0.30 rad"));
}

TEST(Followers, TheJointWithTheActuatorLeads) {
  const std::string tie =
      "<equality><joint joint1='index_1' joint2='index_2' polycoef='0.1 0.5 0 0 0'/></equality>";
  EXPECT_EQ(actuator(hand_with(tie), "index_2").joints.size(), 2U);
  const auto result = hand_with(tie + "<actuator><motor joint='index_1'/></actuator>");
  const hand::Actuator& one = actuator(result, "index_1");
  ASSERT_EQ(one.joints.size(), 2U);
  EXPECT_NEAR(one.joints[1].share, 2, 1e-12);
  EXPECT_NEAR(one.joints[1].offset, -0.2, 1e-12);
}

TEST(Followers, AJointMayBeTheFirstOfTwoEqualities) {
  const auto result = hand_with(
      "<equality><joint joint1='index_1' joint2='index_2'/>"
      "<joint joint1='index_1' joint2='ring_2'/></equality>");
  EXPECT_EQ(result.hand.actuator_count(), 4);
  EXPECT_EQ(actuator(result, "index_1").joints.size(), 3U);
}

TEST(Followers, AUrdfsMimicMayBeWrittenInAnyWayOfXml) {
  const auto share = [&](const std::string& text) {
    return actuator(described("mimic.urdf", text), "finger&1").joints.at(1).share;
  };
  std::string text = kHandUrdf;
  for (const std::string name : {"joint name=\"finger_1\"", "mimic joint=\"finger_1\""}) {
    text = replaced(text, name, replaced(name, "_", "&amp;"));
  }
  EXPECT_EQ(share(text), 0.8);
  EXPECT_EQ(share(replaced(text, "<joint name", "<![CDATA[ <joint><mimic> ]]><joint name")), 0.8);
  EXPECT_EQ(share(replaced(text, "<robot ", "<!-- <mimic> --><robot ")), 0.8);
}

TEST(Followers, AMimicOfAFixedJointIsNone) {
  const auto text = replaced(replaced(kHandUrdf, "joint name=\"finger_2\" type=\"revolute\"",
                                      "joint name=\"finger_2\" type=\"fixed\""),
                             "joint=\"finger_1\" multiplier", "joint=\"gone\" multiplier");
  const auto result = described("fixed.urdf", text);
  EXPECT_EQ(result.hand.joint_count(), 3);
  EXPECT_TRUE(result.problems.empty()) << result.problems.front().what;
}

/// By itself the simulator takes a limit of one bound for none.
TEST(Urdf, IsOneByItsFirstElement) {
  const auto text = replaced(kHandUrdf, "lower=\"0\" upper=\"1.4\"", "lower=\"-1.3\"");
  const auto hand = described("robot.xml", "<?xml version='1.0'?><!-- a hand -->" + text).hand;
  EXPECT_EQ(hand.joints[0].range.high, 0);
}

TEST(Urdf, AnInfiniteEffortIsNoLimit) {
  const auto text = replaced(kHandUrdf, "effort=\"2\"", "effort=\"inf\"");
  EXPECT_TRUE(says(described("effort.urdf", text).guesses,
                   "1 N m is the torque limit of finger_1, for which the file has no finite one"));
}

TEST(ClosedLoops, OneThatIsNotActiveIsNone) {
  EXPECT_EQ(hand_with("<equality><weld body1='index_tip' body2='ring_tip' active='false'/>"
                      "</equality>")
                .hand.joint_count(),
            6);
}

TEST(Slides, AreRefusedWithTheWayOut) {
  const auto text =
      replaced(kHandMjcf, "<body name=\"palm\">",
               "<body name=\"rail\"><geom size=\"0.01\" pos=\"0 0 0.2\"/><body name=\"palm\">"
               "<joint name=\"lift\" type=\"slide\" range=\"0 1\"/>");
  const auto why = error_message(
      [&] { described("rail.xml", replaced(text, "</worldbody>", "</body></worldbody>")); });
  EXPECT_NE(why.find("joint lift is a slide, and sliding joints are not supported"), why.npos);
  EXPECT_NE(why.find("root = \"palm\" in a TOML file"), why.npos);
}

TEST(Notes, ErrorsNameTheirFile) {
  write_hand("hand.xml", kHandMjcf);
  const auto file = write_hand("notes.toml", "model = \"hand.xml\"\nthumb = \"daumen\"\n").string();
  EXPECT_NE(error_message([&] { (void)load_hand(file); }).find("notes.toml"), std::string::npos);
}

}  // namespace
}  // namespace palpate::simulation
