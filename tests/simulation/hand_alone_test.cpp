// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/hand_alone.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>

#include "hand_files.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand/hand_joints.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/scenes.hpp"
#include "simulation/world/scene.hpp"

namespace palpate::simulation {
namespace {

constexpr int kBodies = 8, kJoints = 6;  // of the hand, with the world

/// The hand's text with more around its palm, and more after its bodies.
std::string around(const std::string& before, const std::string& after,
                   const std::string& end = "</worldbody>") {
  return replaced(replaced(kHandMjcf, "<worldbody>", "<worldbody>" + before), "</worldbody>",
                  after + end);
}

hand::Description described(const std::string& text, const HandNotes& notes = {}) {
  return describe_hand(write_hand("hand.xml", text), notes).hand;
}

/// The simulator's model of the hand alone.
ModelHandle compiled(const hand::Description& hand) { return compile(*parse_hand(hand)); }

Eigen::Isometry3d pose_of_root(const mjModel& model) {
  return pose3(model.body_pos + 3, model.body_quat + 4);
}

void expect_same(const Eigen::Isometry3d& one, const Eigen::Isometry3d& other) {
  EXPECT_NEAR((one.matrix() - other.matrix()).norm(), 0, 1e-9) << one.matrix();
}

TEST(HandAlone, OptionsOfTheFileDoNotReachTheSimulation) {
  const auto text =
      replaced(kHandMjcf, "<compiler angle=\"radian\"/>",
               "<compiler angle=\"radian\"/><option gravity=\"0 0 1\" iterations=\"1\" "
               "density=\"1000\"><flag contact=\"disable\" energy=\"enable\"/></option>");
  const SpecHandle spec = parse_model(write_hand("option.xml", text));
  EXPECT_EQ(spec->option.gravity[2], -9.81);
  EXPECT_GT(spec->option.iterations, 1);
  EXPECT_EQ(spec->option.density, 0);
  EXPECT_EQ(spec->option.disableflags | spec->option.enableflags, 0);
}

TEST(HandAlone, OtherBodiesOfASceneGoWithAllThatRefersToThem) {
  const auto text = around(
      "<geom name=\"floor\" type=\"plane\" size=\"1 1 0.1\"/><body name=\"target\" mocap=\"true\"/>"
      "<body name=\"object\"><freejoint name=\"free\"/><geom name=\"cube\" size=\"0.03\"/></body>",
      "",
      "</worldbody><equality><weld body1=\"target\" body2=\"palm\"/></equality>"
      "<contact><exclude body1=\"object\" body2=\"palm\"/>"
      "<pair geom1=\"cube\" geom2=\"floor\"/></contact>"
      "<keyframe><key qpos=\"0 0 0 1 0 0 0 0 0 0 0 0 0\"/></keyframe>");
  const ModelHandle model = compiled(described(text));
  EXPECT_EQ(model->nbody, kBodies);
  EXPECT_EQ(model->njnt, kJoints);
  EXPECT_EQ(model->neq + model->nexclude + model->npair + model->nmocap, 0);
}

TEST(HandAlone, BodiesAboveTheRootAreLeftOut) {
  const auto text = around(
      "<body name=\"mount\" pos=\"0 0 0.4\" euler=\"0 3 0\"><geom name=\"plate\" size=\"0.02\"/>"
      "<body name=\"slider\"><joint name=\"lift\" type=\"slide\" axis=\"0 0 1\"/><geom "
      "size=\"0.01\"/>",
      "</body></body>", "</worldbody><actuator><position joint=\"lift\" kp=\"9\"/></actuator>");
  HandNotes notes;
  notes.root = "palm";
  const hand::Description hand = described(text, notes);
  const ModelHandle model = compiled(hand);
  EXPECT_EQ(model->nbody, kBodies);
  EXPECT_EQ(model->njnt, kJoints);
  EXPECT_EQ(model->nu, 0);
  expect_same(pose_of_root(*model), hand.file.T_mount_root);
  expect_same(hand.file.T_mount_root, described(kHandMjcf).file.T_mount_root);
}

TEST(HandAlone, ActuatorsOfTheHandsOwnJointsGoWithThem) {
  std::string text = replaced(kHandMjcf, "<body name=\"palm\">",
                              "<body name=\"palm\"><joint name=\"x\" type=\"slide\"/>");
  text = replaced(text, "</worldbody>",
                  "</worldbody><actuator><motor name=\"drive\" joint=\"x\"/></actuator>"
                  "<equality><joint joint1=\"x\"/></equality>");
  EXPECT_EQ(compiled(described(text))->nu, 0);
}

TEST(HandAlone, AFrameAroundTheRootDoesNotMoveIt) {
  const hand::Description hand =
      described(around("<frame pos=\"0.1 0.05 0.3\" euler=\"0.4 3.1 0.5\">", "</frame>"));
  expect_same(pose_of_root(*compiled(hand)), hand.file.T_mount_root);
}

TEST(HandAlone, AFrameAroundAFingertipDoesNotMoveItTwice) {
  const std::string tip = "<geom type=\"capsule\" size=\"0.008\" fromto=\"0.008 0 0 0.03 0 0\"/>";
  const hand::Description hand = described(
      replaced(kHandMjcf, tip,
               "<frame pos=\"0.03 0 0\" euler=\"0 1.5707963267948966 0\"><geom type=\"capsule\" "
               "size=\"0.008\" fromto=\"0 0 -0.022 0 0 0\"/></frame>"));
  const hand::Finger& finger = hand.fingers.front();
  EXPECT_NEAR((finger.tip.b - Eigen::Vector3d(0.03, 0, 0)).norm(), 0, 1e-9);
  const ModelHandle model = compiled(hand);
  const int geom = find_id(*model, mjOBJ_GEOM, tip_geom(hand, 0));
  const Eigen::Vector3d middle = vector3(model->geom_pos + 3 * geom);
  EXPECT_NEAR((middle - 0.5 * (finger.tip.a + finger.tip.b)).norm(), 0, 1e-9);
}

TEST(HandAlone, AGeomGivenByItsEndsIsInTheirMiddle) {
  const std::array<double, 6> ends = {0.01, 0, 0, 0.03, 0, 0};
  const SpecHandle spec(mj_makeSpec());
  mjsGeom* const added = mjs_addGeom(mjs_findBody(spec.get(), "world"), nullptr);
  std::copy(ends.begin(), ends.end(), added->fromto);
  EXPECT_NEAR((middle_in_body(*added) - Eigen::Vector3d(0.02, 0, 0)).norm(), 0, 1e-12);
}

TEST(HandAlone, TendonsAreLeftOutOfTheSimulation) {
  const auto text = around("", "",
                           "</worldbody><tendon><fixed name=\"pull\" limited=\"true\" range=\"0 "
                           "0.4\"><joint joint=\"index_1\" coef=\"1\"/></fixed></tendon>"
                           "<actuator><motor tendon=\"pull\"/></actuator>");
  const ModelHandle model = compiled(described(text));
  EXPECT_EQ(model->ntendon, 0);
  EXPECT_EQ(model->nu, 0);
}

TEST(HandAlone, SpringsAreLeftOutAndReported) {
  const auto text = replaced(kHandMjcf, "<joint name=\"index_1\"",
                             "<joint name=\"index_1\" stiffness=\"2\" springref=\"-0.5\"");
  const auto result = describe_hand(write_hand("spring.xml", text));
  ASSERT_EQ(result.problems.size(), 1u);
  EXPECT_EQ(result.problems[0].what, "springs of 1 joints are left out");
  const SpecHandle spec = parse_hand(result.hand);
  prepare_joints(*spec, result.hand, 1);
  const ModelHandle model = compile(*spec);
  for (int joint = 0; joint < model->njnt; ++joint) EXPECT_EQ(model->jnt_stiffness[joint], 0);
}

/// Names that the simulation once gave to what it adds.
TEST(HandAlone, AFileMayUseAnyName) {
  std::string text = replaced(kHandMjcf, "name=\"index_1\"", "name=\"mount_yaw\"");
  text = replaced(text, "name=\"index_2\"", "name=\"joint_2\"");
  text = replaced(text, "<joint name=\"ring_1\"", "<joint");
  text = replaced(text, "<geom type=\"box\"", "<geom name=\"tip_index\" type=\"box\"");
  text = replaced(text, "<geom type=\"capsule\"", "<geom name=\"table\" type=\"capsule\"");
  text = replaced(text, "name=\"index_base\"", "name=\"object\"");
  const geometry::KnownObject object = block();
  const geometry::MeshQuery mesh(object.mesh);
  const geometry::CapsuleCollider surface(mesh);
  const Scene scene =
      compose_scene(described(text), believed_object(object), surface, without_noise());
  EXPECT_EQ(scene.joint_positions.size(), static_cast<std::size_t>(kJoints));
}

TEST(HandAlone, LinksWithoutAMassGetALittle) {
  std::string text = kHandUrdf;
  text = replaced(text, "</robot>",
                  "<link name=\"virtual\"/>" +
                      urdf_joint("spread", "palm", "virtual", "xyz=\"0.05 0 0\"") + "</robot>");
  text = replaced(text, "<parent link=\"palm\"/><child link=\"finger_base\"/>",
                  "<parent link=\"virtual\"/><child link=\"finger_base\"/>");
  const auto result = describe_hand(write_hand("virtual.urdf", text));
  EXPECT_EQ(result.hand.joint_count(), 5);
  ASSERT_FALSE(result.problems.empty());
  EXPECT_EQ(result.problems[0].what, "links without a mass get 1 g: virtual");
}

TEST(HandAlone, AHandWithoutAnyMassCanBeSimulated) {
  const auto text =
      replaced(kHandMjcf, "<worldbody>", "<default><geom mass=\"0\"/></default><worldbody>");
  const geometry::KnownObject object = block();
  const geometry::MeshQuery mesh(object.mesh);
  const geometry::CapsuleCollider surface(mesh);
  const Scene scene =
      compose_scene(described(text), believed_object(object), surface, without_noise());
  EXPECT_EQ(scene.model->body_mass[scene.root], 1e-3);
}

/// The palm's shape as a mesh.
std::string with_mesh(const std::string& uri) {
  return replaced(kHandUrdf, "<box size=\"0.04 0.014 0.014\"/>",
                  "<mesh filename=\"" + uri + "\" scale=\"0.001 0.001 0.001\"/>");
}

/// A tetrahedron of 30 mm, as text.
std::string text_stl() {
  const std::array<const char*, 4> corners = {"0 0 0", "30 0 0", "0 30 0", "0 0 30"};
  std::string text = "solid palm\n";
  for (const auto& t : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int corner : t) {
      text += std::string("vertex ") + corners[static_cast<std::size_t>(corner)] + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid palm\n";
}

TEST(HandMeshes, APackageIsLookedForUpwardsAndThenBesideTheFile) {
  const auto folder = write_hand("any", "").parent_path();
  std::filesystem::create_directories(folder / "ability/meshes");
  std::filesystem::create_directories(folder / "ability/urdf");
  write_file_atomically(folder / "ability/meshes/palm.stl", text_stl());
  const std::string text = with_mesh("package://ability/meshes/palm.stl");
  write_file_atomically(folder / "ability/urdf/hand.urdf", text);
  write_file_atomically(folder / "ability/other.urdf",
                        with_mesh("model://another_name/meshes/palm.stl"));
  EXPECT_EQ(describe_hand(folder / "ability/urdf/hand.urdf").hand.joint_count(), 4);
  EXPECT_EQ(describe_hand(folder / "ability/other.urdf").hand.joint_count(), 4);
  const auto file = "file://" + (folder / "ability/meshes/palm.stl").string();
  EXPECT_EQ(describe_hand(write_hand("file.urdf", with_mesh(file))).hand.joint_count(), 4);
}

TEST(HandMeshes, AMissingOneOfAPackageIsNamed) {
  try {
    (void)describe_hand(write_hand("gone.urdf", with_mesh("package://ability/meshes/gone.stl")));
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("ability/meshes/gone.stl is neither in a folder"),
              std::string::npos)
        << error.what();
  }
}

TEST(HandMeshes, ANameOfManyLinesIsShownInOneShortOne) {
  const std::string name = "package://ability/&#10;" + std::string(60'000, 'x') + ".stl";
  try {
    (void)describe_hand(write_hand("long.urdf", with_mesh(name)));
    FAIL();
  } catch (const BadInput& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("ability/"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 2000) << message;
  }
}

}  // namespace
}  // namespace palpate::simulation
