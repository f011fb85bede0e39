// SPDX-License-Identifier: Apache-2.0
#include <H5Cpp.h>
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "core/error_message.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/recording/writer.hpp"
#include "recording/same_recording.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

/// A gripper with every posture that a hand may have.
hand::Description posed_gripper() {
  hand::Description hand = hand::two_finger_hand();
  const hand::ActuatorVector some{{-0.1, 0.2}}, other{{-1.7, 1.1}}, none;
  hand::Postures& postures = hand.postures;
  postures.flat = {some, {0.5, 0.1}, {0.07, -0.005}};
  postures.pointing.push_back({1, other, {1.35, 0.2}});
  postures.stretched = some;
  postures.folded = none;  // it has none such
  postures.released = other;
  postures.top.open = postures.top.contact_torque = some;
  postures.top.closed = other;
  postures.top.attitudes.push_back({0.4, -0.3});
  postures.top.attitudes.push_back({0.9, 0.3});
  postures.top.offset << 0.01, 0.02;
  postures.top.height = 0.03;
  postures.side.open = postures.side.contact_torque = other;
  postures.side.closed = some;
  postures.side.height = 0.07;
  postures.far_attitudes.push_back({0.9, -1.2});
  hand.kinematic_error = 0.0013;
  return hand;
}

TEST(RecordedHand, AHandOfAnotherSizeReadsBackBitForBit) {
  const TestFolder folder;
  const Recording written = toy_recording(120, posed_gripper());
  ASSERT_EQ(written.frames[0].reading.joints.size(), 3);
  ASSERT_EQ(written.frames[0].reading.torques.size(), 2);
  ASSERT_EQ(written.frames[0].reading.contacts.size(), 2u);
  write_recording(folder / "gripper.h5", written);
  expect_same_recording(read_recording(folder / "gripper.h5"), written);
}

TEST(RecordedHand, AFingertipsHullReadsBackAndABadOneIsRefused) {
  const TestFolder folder;
  hand::Description hand = posed_gripper();
  hand.fingers[1].hull = {{{0, 0, 0}, {0.01, 0, 0.1 / 3}, {0, 0.01, 0}, {0, 0, 0.02}}, 0.001};
  const Recording written = toy_recording(3, hand);
  write_recording(folder / "hull.h5", written);
  expect_same_recording(read_recording(folder / "hull.h5"), written);
  hand.fingers[1].hull->core.resize(3);
  EXPECT_NE(error_message([&] {
              write_recording(folder / "bad.h5", toy_recording(3, hand));
            }).find("hull of 3 points"),
            std::string::npos);
}

TEST(RecordedHand, RefusesFramesOfAnotherHandsSize) {
  const TestFolder folder;
  for (const auto& spoil : std::initializer_list<std::function<void(Frame&)>>{
           [](Frame& frame) { frame.reading.joints.setZero(4); },
           [](Frame& frame) { frame.reading.torques.resize(0); },
           [](Frame& frame) { frame.reading.contacts.emplace_back(); },
           [](Frame& frame) { frame.command.positions.setZero(20); }}) {
    Recording recording = toy_recording(3, posed_gripper());
    spoil(recording.frames[1]);
    EXPECT_NE(error_message([&] {
                write_recording(folder / "bad.h5", recording);
              }).find("the hand 3 joints, 2 actuators and 2 fingers"),
              std::string::npos);
  }
}

TEST(RecordedHand, RefusesAHandThatCannotBe) {
  const TestFolder folder;
  const auto refuses = [&](const std::string& words, const auto& spoil) {
    Recording recording = toy_recording(0, posed_gripper());
    spoil(recording.header.hand);
    const std::string message =
        error_message([&] { write_recording(folder / "bad.h5", recording); });
    EXPECT_NE(message.find(words), std::string::npos) << words << ": " << message;
  };
  using Hand = hand::Description;
  refuses("joint 3", [](Hand& hand) { hand.actuators[0].joints[0].joint = 3; });
  refuses("finger 2", [](Hand& hand) { hand.actuators[0].finger = 2; });
  refuses("couples 1 joints", [](Hand& hand) { hand.actuators[0].coupling.emplace(); });
  refuses("from 0.2 to -2.4", [](Hand& hand) { hand.actuators[0].command = {0.2, -2.4}; });
  refuses("thumb 5", [](Hand& hand) { hand.thumb = 5; });
  refuses("3 values", [](Hand& hand) { hand.postures.top.open.setZero(3); });
  refuses("pointing finger 7", [](Hand& hand) { hand.postures.pointing[0].finger = 7; });
  refuses("33 joints", [](Hand& hand) { hand.joints.resize(33); });
  refuses("9 fingers", [](Hand& hand) { hand.fingers.resize(9, hand.fingers[0]); });
  refuses("0 joints and 0 actuators", [](Hand& hand) {
    hand.joints.clear();
    hand.actuators.clear();
  });
}

/// Puts another header into a recording, and takes the checksum off it.
void rewrite_header(const std::filesystem::path& path, int version,
                    const std::function<void(nlohmann::json&)>& change) {
  {
    const H5::H5File file(path.string(), H5F_ACC_RDWR);
    const H5::DataSet dataset = file.openDataSet("header/json");
    const auto size = static_cast<std::size_t>(dataset.getSpace().getSimpleExtentNpoints());
    std::string text(size, ' ');
    dataset.read(text.data(), H5::PredType::NATIVE_CHAR);
    nlohmann::json header = nlohmann::json::parse(text);
    change(header);
    text = header.dump();
    ASSERT_LE(text.size(), size);
    text.resize(size, ' ');
    dataset.write(text.data(), H5::PredType::NATIVE_CHAR);
  }
  write_open_seal_of(path, version);
}

TEST(RecordedHand, RefusesAnIndexThatIsNotWhole) {
  const TestFolder folder;
  write_recording(folder / "bad.h5", toy_recording(0, posed_gripper()));
  rewrite_header(folder / "bad.h5", 2, [](nlohmann::json& header) {
    header.at("hand").at("name") = "";  // room for more digits
    header.at("hand").at("actuators").at(0).at("finger") = 0.7;
  });
  const std::string message = error_message([&] { read_recording(folder / "bad.h5"); });
  EXPECT_NE(message.find("a finger 0.7 is not a whole number"), std::string::npos) << message;
}

TEST(RecordedHand, AHandWithoutActuatorsIsTheShadowHandOfOlderVersions) {
  const TestFolder folder;
  for (const int version : {1, 2}) {
    const Recording written = toy_recording(20);
    write_recording(folder / "old.h5", written);
    rewrite_header(folder / "old.h5", version, [](nlohmann::json& header) {
      for (const char* key : {"name", "joints", "actuators", "fingers", "thumb", "postures"}) {
        ASSERT_EQ(header.at("hand").erase(key), 1u) << key;
      }
    });
    const Recording read = read_recording(folder / "old.h5");
    expect_same_drives(read.header.hand, hand::shadow_hand());
    expect_same_recording(read, written);
  }
}

}  // namespace
}  // namespace palpate::recording
