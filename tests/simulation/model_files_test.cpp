// SPDX-License-Identifier: Apache-2.0
// What the simulator makes of a hand's file, where by itself it would make something else of it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "hand_files.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand/hand_joints.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

/// The model of a hand as it is simulated.
ModelHandle simulated(const hand::Description& hand) {
  const SpecHandle spec = parse_hand(hand);
  prepare_joints(*spec, hand, 1);
  return compile(*spec);
}

struct Tie {
  std::string leader;
  double offset, ratio;
};

/// The model's active ties of joints, by follower.
std::map<std::string, Tie> ties(const mjModel& model) {
  std::map<std::string, Tie> result;
  for (int i = 0; i < model.neq; ++i) {
    if (model.eq_type[i] != mjEQ_JOINT || !model.eq_active0[i]) continue;
    const auto name = [&](int joint) -> std::string {
      return joint < 0 ? "" : mj_id2name(&model, mjOBJ_JOINT, joint);
    };
    const mjtNum* const data = model.eq_data + mjNEQDATA * i;
    result[name(model.eq_obj1id[i])] = {name(model.eq_obj2id[i]), data[0], data[1]};
  }
  return result;
}

hand::Description hand_with(const std::string& more, std::string text = kHandMjcf) {
  text = replaced(text, "</worldbody>", "</worldbody>" + more);
  return describe_hand(write_hand("hand.xml", text)).hand;
}

const std::string kTendon =
    "<tendon><fixed name=\"t\"><joint joint=\"index_2\" coef=\"1\"/><joint joint=\"index_1\" "
    "coef=\"-0.5\"/></fixed></tendon>";

TEST(Ties, OfATendonAreKeptBesideOtherEqualities) {
  const auto hand = hand_with(kTendon +
                              "<equality><tendon tendon1=\"t\"/><joint joint1=\"ring_2\" "
                              "joint2=\"ring_1\" polycoef=\"0 0.7 0 0 0\"/></equality>");
  const auto found = ties(*simulated(hand));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found.at("ring_2").leader, "ring_1");
  EXPECT_EQ(found.at("ring_2").ratio, 0.7);
  EXPECT_EQ(found.at("index_2").leader, "index_1");
  EXPECT_EQ(found.at("index_2").ratio, 0.5);
}

TEST(Ties, OfJointsThatAreTiedByOthersAreNotAddedTwice) {
  const auto hand = hand_with(
      "<equality><joint joint1=\"index_1\" joint2=\"index_2\"/>"
      "<joint joint1=\"index_1\" joint2=\"ring_2\"/>"
      "<joint joint1=\"thumb_1\" polycoef=\"0.3 0 0 0 0\"/></equality>");
  EXPECT_EQ(simulated(hand)->neq, 3);
}

/// At its `ref` a joint is as the file draws it, and an equality counts from there.
TEST(Ties, CountFromWhereTheFileDrawsTheJoints) {
  const std::string joint = "name=\"index_2\" axis=\"0 1 0\"";
  const auto hand = hand_with(kTendon + "<equality><tendon tendon1=\"t\"/></equality>",
                              replaced(kHandMjcf, joint, joint + " ref=\"0.2\""));
  const ModelHandle model = simulated(hand);
  const hand::Actuator& drive = hand.actuators[static_cast<std::size_t>(hand.actuator("index_1"))];
  const Tie tie = ties(*model).at("index_2");
  const double at_rest = model->qpos0[model->jnt_qposadr[find_id(*model, mjOBJ_JOINT, "index_2")]];
  EXPECT_NEAR(at_rest, 0.2, 1e-12);
  EXPECT_NEAR(tie.offset + at_rest, drive.joints[1].offset, 1e-12);
}

TEST(Ranges, OfAFileInDegreesAreKept) {
  std::string text = replaced(kHandMjcf, "<compiler angle=\"radian\"/>", "");
  for (const auto& [from, to] : {std::pair("0 1.6", "0 91"), std::pair("0 1.4", "0 80")}) {
    while (text.find(from) != std::string::npos) text = replaced(text, from, to);
  }
  const auto hand = hand_with("", text);
  const ModelHandle model = simulated(hand);
  for (const hand::Joint& joint : hand.joints) {
    const int id = find_id(*model, mjOBJ_JOINT, joint.name);
    EXPECT_NEAR(model->jnt_range[2 * id + 1], joint.range.high, 1e-12) << joint.name;
  }
  EXPECT_NEAR(hand.joints[0].range.high, 91 * std::numbers::pi / 180, 1e-12);
}

std::string cube(double half) {
  std::string text;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [&](int bit) { return corner & bit ? half : -half; };
    text += fmt::format("v {} {} {}\n", 0.02 + side(1), side(2), side(4));
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

/// Half the width of the tip of a finger that is drawn by one mesh and collides with another.
double tip_radius(const std::string& drawn, const std::string& collides,
                  const std::string& scale = "1 1 1", const std::string& compiler = "") {
  const auto at = kHandUrdf.find("link name=\"finger_tip\"");
  const std::string visual =
      "<visual><geometry><mesh filename=\"" + drawn + "\"/></geometry></visual><inertial>";
  const std::string mesh = "<mesh filename=\"" + collides + "\" scale=\"" + scale + "\"/>";
  const std::string link = replaced(kHandUrdf.substr(at), "<box size=\"0.04 0.014 0.014\"/>", mesh);
  const auto text = kHandUrdf.substr(0, at) + replaced(link, "<inertial>", visual);
  const std::string robot = "<robot name=\"gripper\">";
  const auto file = write_hand(
      "hand.urdf", replaced(text, robot, robot + "<mujoco><compiler " + compiler + "/></mujoco>"));
  return describe_hand(file).hand.fingers[0].tip.radius;
}

TEST(Meshes, OfOneNameInTwoFoldersAreTwo) {
  write_hand("visual/tip.obj", cube(0.010));
  write_hand("collision/tip.obj", cube(0.006));
  write_hand("alone/tip.obj", cube(0.008));
  EXPECT_NEAR(tip_radius("visual/tip.obj", "collision/tip.obj"), 0.006, 1e-6);
  EXPECT_NEAR(tip_radius("collision/tip.obj", "visual/tip.obj"), 0.010, 1e-6);
  EXPECT_NEAR(tip_radius("collision/tip.obj", "alone/tip.obj"), 0.008, 1e-6);
}

/// The simulator calls the second tip1, and tip1.obj, too.
TEST(Meshes, OfTwoScalesAreTwo) {
  write_hand("tip.obj", cube(0.010));
  write_hand("tip1.obj", cube(0.006));
  EXPECT_NEAR(tip_radius("tip.obj", "tip.obj", "1 0.5 0.5"), 0.005, 1e-6);
  EXPECT_NEAR(tip_radius("tip1.obj", "tip.obj", "1 0.5 0.5"), 0.005, 1e-6);
}

TEST(Meshes, OfAFileThatStripsPathsAreInItsFolder) {
  const std::string compiler = "strippath=\"true\" meshdir=\"parts\"";
  write_hand("parts/tip.obj", cube(0.006));
  EXPECT_NEAR(tip_radius("package://hand/visual/tip.dae", "package://hand/collision/tip.obj",
                         "1 1 1", compiler),
              0.006, 1e-6);
}

/// A file that attaches another has its own folders of meshes and its own units of angles.
TEST(Meshes, OfAnAttachedFileAreBesideIt) {
  write_hand("child/meshes/c.obj", cube(0.006));
  const std::string capsule =
      "<geom type=\"capsule\" size=\"0.008\" fromto=\"0.008 0 0 0.03 0 0\"/>";
  std::string child = replaced(kHandMjcf, capsule, "<geom type=\"mesh\" mesh=\"c\"/>");
  child = replaced(child, "<compiler angle=\"radian\"/>",
                   "<compiler angle=\"radian\" meshdir=\"meshes\"/>"
                   "<asset><mesh name=\"c\" file=\"c.obj\"/></asset>");
  write_hand("child/child.xml", child);
  const auto hand = describe_hand(write_hand(
      "parent.xml",
      "<mujoco><asset><model name=\"child\" file=\"child/child.xml\"/></asset><worldbody>"
      "<attach model=\"child\" body=\"palm\" prefix=\"l_\"/></worldbody></mujoco>"));
  EXPECT_NEAR(hand.hand.fingers[0].tip.radius, 0.006, 1e-6);
  const ModelHandle model = simulated(hand.hand);
  const int joint = find_id(*model, mjOBJ_JOINT, "l_index_1");
  EXPECT_NEAR(model->jnt_range[2 * joint + 1], 1.6, 1e-12);
}

TEST(Meshes, OfAPackageMayBeInAFolderOfAnotherName) {
  write_hand("hand-main/meshes/tip.obj", cube(0.006));
  const std::string mesh = "<mesh filename=\"package://my_hand/meshes/tip.obj\"/>";
  const auto text = replaced(kHandUrdf, "<box size=\"0.04 0.014 0.014\"/>", mesh);
  EXPECT_EQ(describe_hand(write_hand("hand-main/urdf/hand.urdf", text)).hand.finger_count(), 2);
}

TEST(Meshes, MayBePly) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
      "0 -0.006 -0.006\n0 0.006 -0.006\n0 0 0.006\n0.03 0 0\n"
      "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
  write_hand("tip.ply", text);
  EXPECT_NEAR(tip_radius("tip.ply", "tip.ply"), 0.006, 0.001);
}

}  // namespace
}  // namespace palpate::simulation
