// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand_files.hpp"
#include "palpate/core/error.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::simulation {
namespace {

struct Broken {
  std::string name, file, text;
  std::string expected;  ///< must stand in the message
};

void PrintTo(const Broken& broken, std::ostream* out) { *out << broken.name; }

std::string mjcf(const std::string& from, const std::string& to) {
  return replaced(kHandMjcf, from, to);
}

std::string urdf(const std::string& from, const std::string& to) {
  return replaced(kHandUrdf, from, to);
}

std::string without_geoms() {
  std::string text = kHandMjcf;
  for (auto at = text.find("<geom"); at != std::string::npos; at = text.find("<geom", at + 1)) {
    text.insert(at + 5, " contype=\"0\" conaffinity=\"0\"");
  }
  return text;
}

/// Fingers on the palm, each of so many hinges.
std::string many(int fingers, int hinges) {
  std::string text = "<mujoco><worldbody><body name=\"palm\"><geom size=\"0.01\"/>";
  for (int finger = 0; finger < fingers; ++finger) {
    std::string end;
    for (int hinge = 0; hinge < hinges; ++hinge) {
      const auto name = std::to_string(finger) + "_" + std::to_string(hinge);
      text += "<body name=\"b" + name + "\" pos=\"0.02 0 0\"><joint name=\"j" + name +
              "\" range=\"0 90\"/><geom size=\"0.005\"/>";
      end += "</body>";
    }
    text += end;
  }
  return text + "</body></worldbody></mujoco>";
}

std::string after_bodies(const std::string& more) {
  return mjcf("</worldbody>", "</worldbody>" + more);
}

/// A URDF that collides with a mesh.
std::string with_mesh(const std::string& file) {
  return urdf("<box size=\"0.04 0.014 0.014\"/>", "<mesh filename=\"" + file + "\"/>");
}

std::string nested(int depth) {
  std::string text = "<mujoco>";
  for (int i = 0; i < depth; ++i) text += "<default>";
  return text;
}

const std::string kToml = "model = \"plain.xml\"\n";

class BrokenHand : public testing::TestWithParam<Broken> {};

TEST_P(BrokenHand, IsRefusedInOneLineThatSaysWhatIsWrong) {
  write_hand("plain.xml", kHandMjcf);
  write_hand("pointer.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n");
  const Broken& broken = GetParam();
  const auto file = write_hand(broken.file, broken.text);
  try {
    (void)load_hand(file.string());
    FAIL() << "it was taken";
  } catch (const BadInput& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(broken.expected), std::string::npos) << message;
    EXPECT_NE(message.find("palpate-hand-files"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

const std::string kTipJoint = "<joint name=\"index_2\" axis=\"0 1 0\" range=\"0 1.4\"/>";

INSTANTIATE_TEST_SUITE_P(
    Files, BrokenHand,
    testing::Values(
        Broken{"Empty", "empty.xml", "", "empty.xml"},
        Broken{"Truncated", "truncated.xml", kHandMjcf.substr(0, 700), "truncated.xml"},
        Broken{"Binary", "binary.xml", std::string("\x7f\x45LF\0\1\2", 7), "binary.xml"},
        Broken{
            "NoMesh", "no_mesh.xml",
            mjcf("<worldbody>", "<asset><mesh name=\"m\" file=\"gone.stl\"/></asset><worldbody>"),
            "gone.stl"},
        Broken{"NoMeshOfAUrdf", "no_mesh.urdf",
               urdf("<box size=\"0.04 0.014 0.014\"/>", "<mesh filename=\"gone.stl\"/>"),
               "gone.stl"},
        Broken{"Xacro", "macros.urdf",
               urdf("<robot name=\"gripper\">",
                    "<robot name=\"gripper\"><!-- ${none} --><xacro:include filename=\"a\"/>"),
               "run xacro on it first"},
        Broken{"NanInertia", "nan.xml",
               mjcf("<geom type=\"capsule\" size=\"0.009\"",
                    "<inertial pos=\"0 0 0\" mass=\"nan\" diaginertia=\"1 1 1\"/><geom "
                    "type=\"capsule\" size=\"0.009\""),
               "nan.xml"},
        Broken{"NegativeMass", "negative.xml",
               mjcf("<geom type=\"capsule\"", "<geom mass=\"-1\" type=\"capsule\""),
               "a shape of the link index_base has a mass of -1 kg"},
        Broken{"NegativeMassOfALink", "negative.urdf",
               urdf("mass value=\"0.05\"", "mass value=\"-0.05\""),
               "the link palm has a mass of -0.05 kg"},
        Broken{"NanPosition", "nan_position.xml", mjcf("pos=\"0.05 0 0\"", "pos=\"0.05 nan 0\""),
               "line 10: <body pos=\"0.05 nan 0\"> is not finite"},
        Broken{"NanLimit", "nan_limit.urdf", urdf("lower=\"0\"", "lower=\"nan\""),
               "<limit lower=\"nan\"> is not finite"},
        Broken{"WrongEndTag", "end.urdf", urdf("</link>", "</links>"), "it is not XML, from line"},
        Broken{"EqualityOfNothing", "typo.xml",
               after_bodies("<equality><joint joint1=\"index_2\" joint2=\"indx_1\"/></equality>"),
               "refers to the joint 'indx_1', which the file lacks; did you mean 'index_1'?"},
        Broken{"ActuatorOfNothing", "typo.xml",
               after_bodies("<actuator><motor name=\"m\" joint=\"indx_1\"/></actuator>"),
               "the actuator 'm' refers to the joint 'indx_1'"},
        Broken{"ExcludeOfNothing", "typo.xml",
               after_bodies("<contact><exclude body1=\"palm\" body2=\"indx_base\"/></contact>"),
               "refers to the body 'indx_base'"},
        Broken{"TendonOfNothing", "typo.xml",
               after_bodies("<tendon><fixed name=\"t\"><joint joint=\"indx_1\" coef=\"1\"/></fixed>"
                            "</tendon>"),
               "the tendon 't' goes over a joint"},
        Broken{"TwoJointsOfOneName", "twins.urdf",
               urdf("joint name=\"thumb_1\"", "joint name=\"finger_1\""),
               "two joints are named 'finger_1'"},
        Broken{"TwoLinksOfOneName", "twins.urdf",
               urdf("link name=\"thumb_base\"", "link name=\"finger_base\""),
               "two links are named 'finger_base'"},
        Broken{"LinksInACircle", "links.urdf",
               urdf("parent link=\"palm\"/><child link=\"finger_base\"",
                    "parent link=\"finger_tip\"/><child link=\"finger_base\""),
               "is below itself"},
        Broken{"MeshOfAnotherFormat", "format.urdf", with_mesh("plain.xml"),
               "plain.xml of link palm is of a format that is not read: convert it to STL or OBJ"},
        Broken{"MeshIsAPointer", "pointer.urdf", with_mesh("pointer.stl"), "run `git lfs pull`"},
        Broken{"MeshElsewhere", "elsewhere.urdf", with_mesh("https://example.org/palm.stl"),
               "is not on this machine"},
        Broken{"ControlCharacters", "escape.xml",
               mjcf("name=\"index_tip\"", "name=\"index&#27;tip\""), "has control characters"},
        Broken{"TooManyCopies", "copies.xml",
               mjcf("<worldbody>",
                    "<worldbody><replicate count=\"1000000000\" offset=\"1 0 0\">"
                    "<geom size=\"0.01\"/></replicate>"),
               "count=\"1000000000\" is more than 10000"},
        Broken{"NoJointName", "no_name.urdf", urdf("joint name=\"thumb_1\"", "joint name=\"\""),
               "a joint has no name"},
        Broken{"NeitherMjcfNorUrdf", "model.sdf", "<sdf><model/></sdf>", "MJCF or URDF is needed"},
        Broken{"ClosingTwice", "closing.toml", kToml + "closing = \"index_1,-index_1\"\n",
               "closing names index_1 twice"},
        Broken{"Nested", "nested.xml", nested(10000), "nested more than 400 deep"},
        Broken{"NanRange", "nan_range.xml", mjcf("range=\"0 1.4\"", "range=\"0 nan\""),
               "nan_range.xml"},
        Broken{"NoJoints", "no_joints.xml",
               "<mujoco><worldbody><body name=\"palm\"><geom size=\"0.1\"/></body></worldbody>"
               "</mujoco>",
               "has joints"},
        Broken{"OneFinger", "one.xml", many(1, 3), "no finger found"},
        Broken{"NineFingers", "nine.xml", many(9, 1), "9 fingers, but at most 8"},
        Broken{"TooManyJoints", "joints.xml", many(5, 7), "35 joints, but at most 32"},
        Broken{"Slide", "slide.xml",
               mjcf(kTipJoint, "<joint name=\"index_2\" type=\"slide\" range=\"0 0.1\"/>"),
               "index_2 is a slide"},
        Broken{"Ball", "ball.xml", mjcf(kTipJoint, "<joint name=\"index_2\" type=\"ball\"/>"),
               "index_2 is a ball"},
        Broken{"ClosedLoop", "loop.xml",
               mjcf("</worldbody>",
                    "</worldbody><equality><connect body1=\"index_tip\" body2=\"ring_tip\" "
                    "anchor=\"0 0 0\"/></equality>"),
               "index_tip and ring_tip are tied in a closed loop"},
        Broken{"CurvedEquality", "curved.xml",
               mjcf("</worldbody>",
                    "</worldbody><equality><joint joint1=\"index_2\" joint2=\"index_1\" "
                    "polycoef=\"0 0 0.6 0 0\"/></equality>"),
               "the equality of joint index_2 is no linear one"},
        Broken{"EqualitiesInACircle", "circle.xml",
               mjcf("</worldbody>",
                    "</worldbody><equality><joint joint1=\"index_2\" joint2=\"index_1\"/>"
                    "<joint joint1=\"ring_1\" joint2=\"index_2\"/>"
                    "<joint joint1=\"index_1\" joint2=\"ring_1\"/></equality>"),
               "is tied to others in a circle"},
        Broken{"Degrees", "degrees.xml", mjcf("range=\"0 1.4\"", "range=\"0 80\""),
               "joint index_2 has the limits 0 .. 80 rad; are these degrees?"},
        Broken{"NothingCollides", "ghost.xml", without_geoms(), "no finger found"},
        Broken{"MimicCircle", "circle.urdf",
               urdf("<limit lower=\"0\"", "<mimic joint=\"finger_2\"/><limit lower=\"0\""),
               "circle of mimics"},
        Broken{"MimicOfNobody", "nobody.urdf",
               urdf("mimic joint=\"finger_1\"", "mimic joint=\"gone\""), "gone"},
        Broken{"MimicNoNumber", "multiplier.urdf",
               urdf("multiplier=\"0.8\"", "multiplier=\"lots\""), "multiplier"},
        Broken{"Millimetres", "millimetres.xml",
               mjcf("name=\"index_base\" pos=\"0.045 0.025 0\"",
                    "name=\"index_base\" pos=\"45 25 0\""),
               "if the model or its meshes are in millimetres, scale them by 0.001"},
        Broken{"ALongShape", "long.xml",
               mjcf("fromto=\"0.01 0 0 0.04 0 0\"", "fromto=\"0.01 0 0 1000000 0 0\""),
               "a shape of link index_base is 1e+06 m large: lengths are metres"},
        Broken{"TipShape", "shape.toml", kToml + "tip_shape = \"ball\"\n",
               "tip_shape = 'ball' is neither capsule nor hull"},
        Broken{"ModelIsToml", "toml.TOML", "model = \"toml.toml\"\n", "is a TOML file"},
        Broken{"NoModel", "no_model.toml", "thumb = \"thumb\"\n", "model = \"FILE\" is missing"},
        Broken{"ModelGone", "gone.toml", "model = \"gone.xml\"\n", "gone.xml"},
        Broken{"UnknownKey", "key.toml", kToml + "thum = \"thumb\"\n", "did you mean thumb?"},
        Broken{"WrongRoot", "root.toml", kToml + "root = \"wrist\"\n", "wrist"},
        Broken{"WrongPalm", "palm.toml", kToml + "palm = \"hand\"\n", "hand"},
        Broken{"WrongTip", "tip.toml", kToml + "tips = \"index_tip,nail\"\n", "nail"},
        Broken{"WrongThumb", "thumb.toml", kToml + "thumb = \"daumen\"\n",
               "thumb = 'daumen' is none of the fingers: index, ring, thumb"},
        Broken{"WrongClosing", "closing.toml", kToml + "closing = \"index_9\"\n", "index_9"},
        Broken{"MountOutOfReach", "mount.toml", kToml + "mount = {given = true, x = 5.0}\n",
               "mount.x = 5.0 is outside"},
        Broken{"NamesTwice", "names.toml", kToml + "fingers = \"a,b,a\"\n",
               "fingers names a twice"},
        Broken{"NoName", "names.toml", kToml + "tips = \"index_tip,,thumb_tip\"\n",
               "tips = 'index_tip,,thumb_tip' has an empty name"},
        Broken{"NamesOfOtherNumber", "names.toml", kToml + "fingers = \"a,b\"\n",
               "names 2 fingers, but the hand has 3"}),
    [](const auto& given) { return given.param.name; });

TEST(BrokenHand, AFileIsNotGivenAllTheMemoryThatItAsksFor) {
  const auto file =
      write_hand("user_data.xml", mjcf("<worldbody>",
                                       "<size nuser_geom=\"2147483647\" nuserdata=\"2147483647\"/>"
                                       "<worldbody>"));
  EXPECT_EQ(load_hand(file).finger_count(), 3);
}

TEST(BrokenHand, AFolderOrNothingAtAllIsNoHand) {
  EXPECT_THROW((void)load_hand("/"), BadInput);
  EXPECT_THROW((void)load_hand("no-such-hand"), BadInput);
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT")) << "the simulator's log was left behind";
}

}  // namespace
}  // namespace palpate::simulation
