// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>

#include "described_hands.hpp"

namespace palpate::simulation {
namespace {

std::string with_effort(const std::string& effort) {
  std::string text = kHandUrdf;
  while (text.find("effort=\"2\"") != std::string::npos) {
    text = replaced(text, "effort=\"2\"", "effort=\"" + effort + "\"");
  }
  return text;
}

TEST(TorqueLimit, OneThatNoFingerHasIsLowered) {
  const auto result = described("effort.urdf", with_effort("1000"));
  for (const hand::Actuator& one : result.hand.actuators) {
    EXPECT_NEAR(one.max_torque / one.lever, 18, 1e-9) << one.name;
  }
  EXPECT_TRUE(says(result.guesses, "torque limits of 1000 N m would press with"));
}

TEST(TorqueLimit, TheUsersIsKept) {
  HandNotes notes;
  notes.max_torque = 50;
  const auto result = described("effort.urdf", with_effort("1000"), notes);
  for (const hand::Actuator& one : result.hand.actuators) EXPECT_EQ(one.max_torque, 50);
  EXPECT_FALSE(says(result.guesses, "torque limits"));
}

TEST(TorqueLimit, APlausibleOneIsKept) {
  const auto result = described("effort.urdf", with_effort("3"));
  for (const hand::Actuator& one : result.hand.actuators) EXPECT_EQ(one.max_torque, 3);
}

struct Drive {
  const char* text;
  double torque;
};

TEST(TorqueLimit, ComesFromForceRangeGainAndGear) {
  for (const auto& [text, torque] : std::initializer_list<Drive>{
           {"<motor joint='index_1' gear='0.35' ctrlrange='-1 1'/>", 0.35},
           {"<motor joint='index_1' gear='2' ctrlrange='-1 1' forcerange='-0.2 0.2'/>", 0.4},
           {"<position joint='index_1' gear='20' kp='0.01' forcerange='-0.03 0.03'/>", 0.6},
           {"<general joint='index_1' gainprm='0.4' biastype='none' ctrlrange='-1 1'/>", 0.4},
           {"<position jointinparent='index_1' kp='3' forcerange='-0.7 0.7'/>", 0.7},
           {"<position tendon='pull' kp='3' forcerange='-0.8 0.8'/>", 0.4},
           {"<position joint='index_1' kp='3' forcerange='-2 0.3'/>", 0.3},
           {"<motor joint='index_1' gear='0.35' ctrlrange='0 1'/>", 0.35},
           {"<position joint='index_1' kp='3' ctrlrange='0 1.6'/>", 1.0}}) {
    const auto result =
        hand_with(fmt::format("<tendon><fixed name='pull'><joint joint='index_1' coef='-0.5'/>"
                              "</fixed></tendon><actuator>{}</actuator>",
                              text));
    EXPECT_NEAR(actuator(result, "index_1").max_torque, torque, 1e-12) << text;
  }
}

TEST(JointRange, ThatOfTheCommandsWhereTheJointHasNone) {
  const auto text = replaced(replaced(kHandMjcf, " range=\"0 1.4\"", ""), "</worldbody>",
                             "</worldbody><actuator><position joint='index_2' kp='3' gear='2' "
                             "ctrlrange='-0.4 2'/></actuator>");
  const auto result = described("unlimited.xml", text);
  EXPECT_NEAR(actuator(result, "index_2").command.low, -0.2, 1e-12);
  EXPECT_NEAR(actuator(result, "index_2").command.high, 1, 1e-12);
  EXPECT_TRUE(reports(result, "the commands of its actuator"));
}

TEST(JointRange, EndsWhereTheCommandsDo) {
  const auto result = hand_with(
      "<actuator><position joint='index_1' kp='3' ctrlrange='0 1'/>"
      "<position joint='index_2' kp='3' ctrlrange='-1 1'/>"
      "<position joint='ring_1' kp='3' ctrlrange='0 1.55'/>"
      "<position joint='thumb_1' kp='3' ctrlrange='0 0.1'/></actuator>");
  EXPECT_NEAR(actuator(result, "index_1").command.high, 1, 1e-12);
  EXPECT_TRUE(says(result.guesses, "index_1 moves from 0.00 to 1.00 rad"));
  EXPECT_NEAR(actuator(result, "index_2").command.high, 1.4, 1e-12);  // a default of many files
  EXPECT_NEAR(actuator(result, "ring_1").command.high, 1.6, 1e-12);   // a rounded one
  EXPECT_NEAR(actuator(result, "thumb_1").command.high, 1.6, 1e-12);  // would leave next to nothing
}

TEST(JointRange, AnInfiniteOneIsNone) {
  const auto text = replaced(kHandMjcf, "range=\"0 1.4\"", "range=\"-inf inf\"");
  EXPECT_TRUE(reports(described("infinite.xml", text), "no limits of joint index_2"));
}

TEST(TorqueLimit, OneThatIsAssumedIsReported) {
  EXPECT_TRUE(says(hand_with("").guesses,
                   "1 N m is the torque limit of index_1, index_2, ring_1 and 3 more"));
  EXPECT_FALSE(says(described("effort.urdf", with_effort("3")).guesses, "1 N m"));
}

TEST(Drives, ThatCannotWorkAreReported) {
  EXPECT_TRUE(described("effort.urdf", with_effort("3")).problems.empty());
  EXPECT_TRUE(reports(described("weak.urdf", with_effort("0.001")),
                      "finger_1, thumb_1 press with less than 1 N at the fingertip"));
  HandNotes notes;
  notes.max_torque = 50;
  EXPECT_TRUE(reports(hand_with("", notes), "max_torque presses with"));
  const auto tip = [](const std::string& inertial) {
    const std::string body = "<body name=\"index_tip\" pos=\"0.05 0 0\">";
    return described("tip.xml", replaced(kHandMjcf, body, body + inertial));
  };
  EXPECT_TRUE(reports(tip("<inertial pos=\"0.02 0 0\" mass=\"8\" diaginertia=\"1e-3 1e-3 1e-3\"/>"),
                      "drives of index_1, index_2 do not carry the weight of their links"));
  EXPECT_TRUE(reports(tip("<inertial pos=\"0 0 0\" mass=\"0.02\" diaginertia=\"1 1 1\"/>"),
                      "accelerate their links by less than 20 rad/s^2"));
  EXPECT_TRUE(reports(described("heavy.xml", replaced(kHandMjcf, "<geom type=\"box\"",
                                                      "<geom mass=\"40\" type=\"box\"")),
                      "the hand has a mass of 40"));
}

TEST(JointRange, ABoundThatAUrdfDoesNotGiveIsZero) {
  const auto range = [](const std::string& limits) {
    return described("bound.urdf", replaced(kHandUrdf, "lower=\"0\" upper=\"1.4\"", limits))
        .hand.joints[0]
        .range;
  };
  EXPECT_EQ(range("upper=\"1.3\"").low, 0);
  EXPECT_EQ(range("upper=\"1.3\"").high, 1.3);
  EXPECT_EQ(range("lower=\"-1.3\"").low, -1.3);
  EXPECT_EQ(range("lower=\"-1.3\"").high, 0);
}

}  // namespace
}  // namespace palpate::simulation
