// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/describe_hand.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hand_files.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/overlapping_links.hpp"

namespace palpate::simulation {
namespace {

hand::Description described(const std::string& name, const std::string& text,
                            const HandNotes& notes = {}) {
  return describe_hand(write_hand(name, text), notes).hand;
}

Eigen::Vector3d tip_of(const hand::Description& hand, int finger, double angle) {
  const auto command = hand::ActuatorVector::Constant(hand.actuator_count(), angle).eval();
  const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, command));
  const auto& one = hand.fingers[static_cast<std::size_t>(finger)];
  return T[static_cast<std::size_t>(one.link)] * one.tip.b;
}

TEST(DescribeHand, FindsFingersTheirTipsAndTheThumb) {
  const auto hand = described("plain.xml", kHandMjcf);
  ASSERT_EQ(hand.finger_count(), 3);
  EXPECT_EQ(hand.fingers[0].name, "index");
  EXPECT_EQ(hand.thumb, 2);
  EXPECT_EQ(hand.joint_count(), 6);
  EXPECT_EQ(hand.actuator_count(), 6);
  EXPECT_NEAR(hand.fingers[1].tip.radius, 0.008, 1e-12);
  EXPECT_NEAR((hand.fingers[1].tip.b - Eigen::Vector3d(0.03, 0, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(hand.links[static_cast<std::size_t>(hand.palm)].name, "palm");
}

TEST(DescribeHand, CarriesTheHandWithItsPalmDownAndItsFingersClosingBelow) {
  const auto hand = described("plain.xml", kHandMjcf);
  for (int finger = 0; finger < 3; ++finger) {
    EXPECT_LT(tip_of(hand, finger, 1.2).z(), tip_of(hand, finger, 0.1).z() - 0.02) << finger;
  }
  EXPECT_GT(tip_of(hand, 0, 0).x(), 0) << "fingers point along +x";
  EXPECT_LT(tip_of(hand, 2, 0).x(), 0) << "the thumb opposes them";
}

TEST(DescribeHand, MakesServosOfOneNaturalFrequency) {
  const auto hand = described("plain.xml", kHandMjcf);
  for (const auto& actuator : hand.actuators) {
    EXPECT_GT(actuator.stiffness, 0);
    EXPECT_GT(actuator.damping, 0);
    EXPECT_NEAR(std::sqrt(actuator.stiffness / actuator.armature), 40, 1e-9) << actuator.name;
    EXPECT_EQ(actuator.max_torque, 1.0) << "the file names none";
    EXPECT_GT(actuator.closing, 0);
  }
}

TEST(DescribeHand, LeavesOutTheJointThatTheFileHangsItOn) {
  const auto free = replaced(kHandMjcf, "<body name=\"palm\">", "<body name=\"palm\"><freejoint/>");
  EXPECT_EQ(described("free.xml", free).joint_count(), 6);
}

TEST(DescribeHand, MimicJointsFollowTheirLeader) {
  const auto hand = described("mimic.urdf", kHandUrdf);
  ASSERT_EQ(hand.joint_count(), 4);
  ASSERT_EQ(hand.actuator_count(), 2);
  const auto& actuator = hand.actuators[0];
  ASSERT_EQ(actuator.joints.size(), 2u);
  EXPECT_EQ(actuator.joints[1].share, 0.8);
  EXPECT_EQ(actuator.joints[1].offset, 0.1);
  EXPECT_EQ(actuator.joints[1].gear, 0);
  EXPECT_EQ(actuator.max_torque, 2) << "the file's effort";
  const auto joints = hand::joints_in_free_flexion(hand, hand::ActuatorVector::Constant(2, 0.5));
  EXPECT_NEAR(joints[hand.joint("finger_2")], 0.8 * 0.5 + 0.1, 1e-12);
  EXPECT_NEAR(joints[hand.joint("thumb_2")], 0.7 * 0.5, 1e-12);
}

/// Tags in comments once cost the square of their number, and a long one the stack.
TEST(DescribeHand, TagsInCommentsAreNoMimics) {
  std::string many = "<!-- ";
  for (int i = 0; i < 100000; ++i) many += "<joint >";
  many += "<mimic joint=\"gone\"/> -->";
  const std::string tail = "<!-- <joint " + std::string(1000000, 'a') + "> --></robot>";
  const auto hand = described(
      "mimic.urdf", replaced(replaced(kHandUrdf, "</robot>", tail), "<robot name=\"gripper\">",
                             "<robot name=\"gripper\">" + many));
  EXPECT_EQ(hand.actuator_count(), 2);
}

TEST(DescribeHand, FitsACapsuleOfAWedgesWidthToAFingertipOfMeshOrBox) {
  const auto hand = described("mimic.urdf", kHandUrdf);
  const auto& tip = hand.fingers[0].tip;
  EXPECT_NEAR(tip.radius, 0.007, 1e-9);
  EXPECT_NEAR(tip.b.x() + tip.radius, 0.04, 1e-9) << "as long as the fingertip";
  EXPECT_NEAR((tip.b - tip.a).norm(), 0.025, 1e-9) << "its outer end only";
}

TEST(DescribeHand, SensesTheCornersOfALinkWithItsBalls) {
  const auto hand = described("mimic.urdf", kHandUrdf);
  double farthest = 0;
  for (const auto& sphere : hand.spheres) {
    if (sphere.link != hand.palm) continue;
    farthest = std::max(farthest, sphere.center.x() + sphere.radius);
  }
  EXPECT_NEAR(farthest, 0.04, 0.0015);
}

/// Three fingers on a circle that point down. Their joints' ranges are the same to both sides, and
/// every second axis points the other way.
std::string claw() {
  std::string text =
      "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"palm\">"
      "<geom type=\"cylinder\" size=\"0.06 0.01\"/>";
  for (int i = 0; i < 3; ++i) {
    text += fmt::format(
        "<body name=\"f{0}\" pos=\"{1} {2} -0.02\" euler=\"0 0 {3}\">"
        "<joint name=\"f{0}_1\" axis=\"0 {4} 0\" range=\"-1.5 1.5\"/>"
        "<geom type=\"capsule\" size=\"0.01\" fromto=\"0 0 -0.01 0 0 -0.05\"/>"
        "<body name=\"f{0}_tip\" pos=\"0 0 -0.06\">"
        "<joint name=\"f{0}_2\" axis=\"0 {5} 0\" range=\"-1.5 1.5\"/>"
        "<geom type=\"capsule\" size=\"0.01\" fromto=\"0 0 -0.01 0 0 -0.05\"/></body></body>",
        i, 0.04 * std::cos(2.0944 * i), 0.04 * std::sin(2.0944 * i), 2.0944 * i, i == 1 ? -1 : 1,
        i == 2 ? -1 : 1);
  }
  return text + "</body></worldbody></mujoco>";
}

TEST(DescribeHand, AClawClosesInwards) {
  const auto hand = described("claw.xml", claw());
  ASSERT_EQ(hand.actuator_count(), 6);
  const Eigen::Vector3d middle = (tip_of(hand, 0, 0) + tip_of(hand, 1, 0) + tip_of(hand, 2, 0)) / 3;
  const auto from_middle = [&](int actuator, double by) {
    auto positions = hand::ActuatorVector::Zero(hand.actuator_count()).eval();
    positions[actuator] = by;
    const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, positions));
    const hand::Actuator& one = hand.actuators[static_cast<std::size_t>(actuator)];
    const hand::Finger& finger = hand.fingers[static_cast<std::size_t>(one.finger)];
    return (T[static_cast<std::size_t>(finger.link)] * finger.tip.b - middle).norm();
  };
  for (int i = 0; i < 6; ++i) {
    const hand::Actuator& one = hand.actuators[static_cast<std::size_t>(i)];
    ASSERT_NE(one.closing, 0) << one.name;
    EXPECT_LT(from_middle(i, std::copysign(0.2, one.closing)), from_middle(i, 0)) << one.name;
  }
}

TEST(DescribeHand, NotesOverrideWhatIsDerived) {
  HandNotes notes;
  notes.fingers = "left, right, thumb";
  notes.tips = "index_tip,ring_tip,thumb_tip";
  notes.thumb = "left";
  notes.closing = "index_2,-ring_2,thumb_1";
  notes.max_torque = 0.7;
  notes.has_mount = true;
  notes.mount_xyz = {0.01, 0.02, 0.03};
  notes.mount_rpy = {0, 180, 0};
  const auto hand = described("plain.xml", kHandMjcf, notes);
  EXPECT_EQ(hand.fingers[1].name, "right");
  EXPECT_EQ(hand.thumb, 0);
  EXPECT_EQ(hand.actuators[static_cast<std::size_t>(hand.actuator("index_1"))].closing, 0);
  EXPECT_GT(hand.actuators[static_cast<std::size_t>(hand.actuator("index_2"))].closing, 0);
  EXPECT_LT(hand.actuators[static_cast<std::size_t>(hand.actuator("ring_2"))].closing, 0);
  EXPECT_EQ(hand.actuators[0].max_torque, 0.7);
  const Eigen::Isometry3d& T = hand.links.front().T_parent_link;
  EXPECT_NEAR((T.translation() - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 0, 1e-12);
  EXPECT_NEAR((T.linear().col(2) + Eigen::Vector3d::UnitZ()).norm(), 0, 1e-12);
}

TEST(DescribeHand, NamesLinksThatOverlapInEveryPosture) {
  // The ring finger starts inside the index finger and stays there.
  const auto text = replaced(kHandMjcf, "pos=\"0.045 -0.025 0\"", "pos=\"0.045 0.015 0\"");
  const auto result = describe_hand(write_hand("overlap.xml", text));
  ASSERT_FALSE(result.problems.empty());
  EXPECT_NE(result.problems.front().what.find("overlap in every posture"), std::string::npos);
  EXPECT_FALSE(result.hand.file.overlapping.empty());
}

TEST(DescribeHand, LinksThatTheFileLetsPassThroughOneAnotherOverlapInAWorldToo) {
  auto text = replaced(kHandMjcf, "pos=\"0.045 -0.025 0\"", "pos=\"0.045 0.015 0\"");
  text = replaced(text, "<worldbody>",
                  "<default><geom contype=\"1\" conaffinity=\"0\"/></default><worldbody>");
  const auto result = describe_hand(write_hand("masked.xml", text));
  EXPECT_TRUE(result.problems.empty()) << result.problems.front().what;
  EXPECT_FALSE(result.hand.file.overlapping.empty());
}

TEST(DescribeHand, PairsOfContactsNameTheFingertipThatReplacesTheFiles) {
  auto text = replaced(kHandMjcf, "<geom type=\"box\"", "<geom name=\"plate\" type=\"box\"");
  text = replaced(text, "<geom type=\"capsule\" size=\"0.008\"",
                  "<geom name=\"pad\" type=\"capsule\" size=\"0.008\"");
  text = replaced(text, "</worldbody>",
                  "</worldbody><contact><pair geom1=\"plate\" geom2=\"pad\"/></contact>");
  const auto hand = described("pair.xml", text);
  const ModelHandle model = compile(*parse_hand(hand));
  ASSERT_EQ(model->npair, 1);
  EXPECT_EQ(model->pair_geom2[0], find_id(*model, mjOBJ_GEOM, tip_geom(hand, 0)));
}

TEST(DescribeHand, NamesTheFirstOfManyTendons) {
  std::string tendons;
  for (int i = 0; i < 5; ++i) {
    tendons += fmt::format("<fixed name=\"t{}\"><joint joint=\"index_1\" coef=\"1\"/></fixed>", i);
  }
  const auto text =
      replaced(kHandMjcf, "</worldbody>", "</worldbody><tendon>" + tendons + "</tendon>");
  const auto result = describe_hand(write_hand("tendons.xml", text));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_EQ(result.problems[0].what, "tendons t0, t1, t2 and 2 more are left out");
}

TEST(DescribeHand, ATendonThatAnEqualityHoldsMakesOneJointFollowTheOther) {
  const auto text =
      replaced(kHandMjcf, "</worldbody>",
               "</worldbody><tendon><fixed name=\"link\"><joint joint=\"index_1\" coef=\"0.4\"/>"
               "<joint joint=\"index_2\" coef=\"-0.5\"/></fixed></tendon>"
               "<equality><tendon tendon1=\"link\"/></equality>"
               "<actuator><position joint=\"index_1\"/></actuator>");
  const auto result = describe_hand(write_hand("tied.xml", text));
  EXPECT_TRUE(result.problems.empty()) << result.problems.front().what;
  EXPECT_EQ(result.hand.actuator_count(), 5);
  const auto& drive =
      result.hand.actuators[static_cast<std::size_t>(result.hand.actuator("index_1"))];
  ASSERT_EQ(drive.joints.size(), 2u);
  EXPECT_NEAR(drive.joints[1].share, 0.8, 1e-12) << "0.4 of the one is 0.5 of the other";
  EXPECT_NEAR(drive.joints[1].offset, 0, 1e-12);
}

TEST(DescribeHand, SaysThatATendonIsLeftOut) {
  const auto text = replaced(kHandMjcf, "</worldbody>",
                             "</worldbody><tendon><fixed name=\"pull\"><joint joint=\"index_1\" "
                             "coef=\"1\"/></fixed></tendon>");
  const auto result = describe_hand(write_hand("tendon.xml", text));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_EQ(result.problems[0].what, "tendon pull is left out");
}

TEST(DescribeHand, TakesInertiasOfADrawingThatBreakTheTriangleInequality) {
  const auto text = replaced(kHandUrdf, "ixx=\"1e-5\"", "ixx=\"9e-5\"");
  EXPECT_EQ(describe_hand(write_hand("inertia.urdf", text)).hand.joint_count(), 4);
}

TEST(DescribeHand, SaysThatAJointHasNoLimits) {
  const auto text = replaced(kHandMjcf, " range=\"0 1.4\"", "");
  const auto result = describe_hand(write_hand("unlimited.xml", text));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_EQ(result.problems[0].what, "no limits of joint index_2");
  EXPECT_NEAR(result.hand.joints[1].range.high, std::numbers::pi / 2, 1e-3);
}

TEST(DescribeHand, SaysThatLimitsAreReversed) {
  const auto text = replaced(kHandMjcf, " range=\"0 1.4\"", " range=\"1.4 0\" limited=\"false\"");
  const auto result = describe_hand(write_hand("reversed.xml", text));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_EQ(result.problems[0].what, "reversed limits of joint index_2");
  EXPECT_EQ(result.hand.joints[1].range.high, 1.4);
}

TEST(DescribeHand, SaysThatRadiansMayBeDegrees) {
  const auto text = replaced(kHandMjcf, "range=\"0 1.4\"", "range=\"0 0.03\"");
  const auto result = describe_hand(write_hand("few_degrees.xml", text));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_NE(result.problems[0].hint.find("degrees"), std::string::npos);
}

/// The file draws the joint bent: at this angle its bodies are as they stand there.
TEST(DescribeHand, AJointMayBeDrawnBent) {
  const auto plain = described("plain.xml", kHandMjcf);
  const auto drawn_bent =
      described("ref.xml", replaced(kHandMjcf, "range=\"0 1.4\"", "range=\"0 1.4\" ref=\"0.5\""));
  hand::ActuatorVector command = hand::ActuatorVector::Zero(plain.actuator_count());
  const auto tip = [&](const hand::Description& hand) {
    const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, command));
    return Eigen::Vector3d(T[static_cast<std::size_t>(hand.palm)].inverse() *
                           T[static_cast<std::size_t>(hand.fingers[0].link)] *
                           hand.fingers[0].tip.b);
  };
  const Eigen::Vector3d straight = tip(plain);
  command[plain.actuator("index_2")] = 0.5;
  EXPECT_NEAR((tip(drawn_bent) - straight).norm(), 0, 1e-9);
  EXPECT_GT((tip(plain) - straight).norm(), 0.01);
}

TEST(DescribeHand, WhatCollidesOneWayOnlyBelongsToTheHand) {
  std::string text = kHandMjcf;
  for (auto at = text.find("<geom"); at != std::string::npos; at = text.find("<geom", at + 1)) {
    text.insert(at + 5, " contype=\"0\" conaffinity=\"1\"");
  }
  EXPECT_EQ(described("one_way.xml", text).spheres.size(),
            described("plain.xml", kHandMjcf).spheres.size());
}

TEST(DescribeHand, ThinFingertipsHaveASurface) {
  const auto text = replaced(kHandMjcf, "size=\"0.008\"", "size=\"0.0028\"");
  const auto hand = described("thin.xml", text);
  const int link = hand.fingers[0].link;
  EXPECT_TRUE(
      std::ranges::any_of(hand.spheres, [&](const auto& ball) { return ball.link == link; }));
}

TEST(DescribeHand, AnEqualityThatIsNotActiveTiesNothing) {
  const auto text = replaced(kHandMjcf, "</worldbody>",
                             "</worldbody><equality><joint joint1=\"index_2\" joint2=\"index_1\" "
                             "active=\"false\"/></equality>");
  EXPECT_EQ(described("inactive.xml", text).actuator_count(), 6);
}

}  // namespace
}  // namespace palpate::simulation
