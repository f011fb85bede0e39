// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "palpate/core/file.hpp"

namespace palpate::simulation {

/// Text with the first `from` replaced. @throws std::out_of_range if it is not there
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// A hand of two fingers and a thumb; each finger has two hinges.
inline const std::string kHandMjcf = R"(
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="palm">
      <geom type="box" size="0.04 0.04 0.01"/>
      <body name="index_base" pos="0.045 0.025 0">
        <joint name="index_1" axis="0 1 0" range="0 1.6"/>
        <geom type="capsule" size="0.009" fromto="0.01 0 0 0.04 0 0"/>
        <body name="index_tip" pos="0.05 0 0">
          <joint name="index_2" axis="0 1 0" range="0 1.4"/>
          <geom type="capsule" size="0.008" fromto="0.008 0 0 0.03 0 0"/>
        </body>
      </body>
      <body name="ring_base" pos="0.045 -0.025 0">
        <joint name="ring_1" axis="0 1 0" range="0 1.6"/>
        <geom type="capsule" size="0.009" fromto="0.01 0 0 0.04 0 0"/>
        <body name="ring_tip" pos="0.05 0 0">
          <joint name="ring_2" axis="0 1 0" range="0 1.4"/>
          <geom type="capsule" size="0.008" fromto="0.008 0 0 0.03 0 0"/>
        </body>
      </body>
      <body name="thumb_base" pos="-0.045 0 0" quat="0 0 0 1">
        <joint name="thumb_1" axis="0 1 0" range="0 1.6"/>
        <geom type="capsule" size="0.009" fromto="0.01 0 0 0.04 0 0"/>
        <body name="thumb_tip" pos="0.05 0 0">
          <joint name="thumb_2" axis="0 1 0" range="0 1.4"/>
          <geom type="capsule" size="0.008" fromto="0.008 0 0 0.03 0 0"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>)";

inline std::string urdf_link(const std::string& name) {
  return "<link name=\"" + name +
         "\"><inertial><mass value=\"0.05\"/>"
         "<inertia ixx=\"1e-5\" iyy=\"1e-5\" izz=\"1e-5\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>"
         "</inertial><collision><origin xyz=\"0.02 0 0\"/>"
         "<geometry><box size=\"0.04 0.014 0.014\"/></geometry></collision></link>\n";
}

inline std::string urdf_joint(const std::string& name, const std::string& parent,
                              const std::string& child, const std::string& origin,
                              const std::string& more = "") {
  return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/><origin " + origin +
         "/><axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"1.4\" effort=\"2\" velocity=\"3\"/>" +
         more + "</joint>\n";
}

/// A gripper of one finger and a thumb, whose last joints follow the first by mimic.
inline const std::string kHandUrdf =
    "<robot name=\"gripper\">\n" + urdf_link("palm") + urdf_link("finger_base") +
    urdf_link("finger_tip") + urdf_link("thumb_base") + urdf_link("thumb_tip") +
    urdf_joint("finger_1", "palm", "finger_base", "xyz=\"0.05 0 0\"") +
    urdf_joint("finger_2", "finger_base", "finger_tip", "xyz=\"0.045 0 0\"",
               "<mimic joint=\"finger_1\" multiplier=\"0.8\" offset=\"0.1\"/>") +
    urdf_joint("thumb_1", "palm", "thumb_base", "xyz=\"-0.03 0 0\" rpy=\"0 0 3.14159265\"") +
    urdf_joint("thumb_2", "thumb_base", "thumb_tip", "xyz=\"0.045 0 0\"",
               "<mimic joint=\"thumb_1\" multiplier=\"0.7\"/>") +
    "</robot>\n";

/// A file in a folder of the test's own.
inline std::filesystem::path write_hand(const std::string& name, const std::string& text) {
  const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
  const auto folder = std::filesystem::temp_directory_path() / "palpate-hand-files" / test;
  std::filesystem::create_directories(folder);
  write_file_atomically(folder / name, text);
  return folder / name;
}

}  // namespace palpate::simulation
