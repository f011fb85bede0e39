// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/recording.hpp"

#include <H5Cpp.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/recording/writer.hpp"
#include "recording/same_recording.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

std::string message_of(const std::filesystem::path& path) {
  try {
    read_recording(path);
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(RecordingTest, ReadsBackBitForBit) {
  const TestFolder folder;
  for (const int ticks : {0, 1, 100, 257}) {
    const Recording written = toy_recording(ticks);
    write_recording(folder / "toy.h5", written);
    const Recording read = read_recording(folder / "toy.h5");
    EXPECT_TRUE(read.finished);
    expect_same_recording(read, written);
  }
}

/// The recording with random counts of BioTacs in every frame, some of them missing.
Recording with_biotacs(Recording recording) {
  RandomStream random(6, "biotacs");
  const auto count = [&] {
    return random.index(9) == 0 ? std::nan("") : static_cast<double>(random.index(4096));
  };
  for (Frame& frame : recording.frames) {
    for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
      hand::BiotacReading biotac;
      biotac.time = frame.reading.time;
      for (double* value : {&biotac.pdc, &biotac.tdc, &biotac.tac}) *value = count();
      for (double& value : biotac.electrodes) value = count();
      for (double& value : biotac.pac) value = count();
      biotac.pac_interpolated = random.index(2) == 0;
      frame.reading.biotacs.push_back(biotac);
    }
  }
  return recording;
}

void expect_same_count(double a, double b) {
  if (std::isnan(a)) {
    EXPECT_TRUE(std::isnan(b)) << b;
  } else {
    EXPECT_EQ(a, b);
  }
}

void expect_same_biotac(const hand::BiotacReading& a, const hand::BiotacReading& b) {
  EXPECT_EQ(a.time, b.time);
  expect_same_count(a.pdc, b.pdc);
  expect_same_count(a.tdc, b.tdc);
  expect_same_count(a.tac, b.tac);
  for (int i = 0; i < hand::kElectrodes; ++i) expect_same_count(a.electrodes[i], b.electrodes[i]);
  for (std::size_t i = 0; i < a.pac.size(); ++i) expect_same_count(a.pac[i], b.pac[i]);
  EXPECT_EQ(a.pac_interpolated, b.pac_interpolated);
}

TEST(RecordingTest, ChannelsOfBiotacsComeBack) {
  const TestFolder folder;
  const Recording written = with_biotacs(toy_recording(120));
  write_recording(folder / "toy.h5", written);
  const Recording read = read_recording(folder / "toy.h5");
  ASSERT_EQ(read.frames.size(), written.frames.size());
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    expect_same_frame(read.frames[i], written.frames[i]);
    const auto &a = read.frames[i].reading.biotacs, &b = written.frames[i].reading.biotacs;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) expect_same_biotac(a[k], b[k]);
  }
}

TEST(RecordingTest, FramesWithAndWithoutBiotacsDoNotMix) {
  const TestFolder folder;
  Recording recording = with_biotacs(toy_recording(3));
  recording.frames[1].reading.biotacs.clear();
  EXPECT_THROW(write_recording(folder / "toy.h5", recording), BadInput);
  recording = with_biotacs(toy_recording(3));
  recording.frames[1].reading.biotacs.pop_back();
  EXPECT_THROW(write_recording(folder / "toy.h5", recording), BadInput);
  recording = with_biotacs(toy_recording(3));
  recording.frames[1].reading.biotacs[2].pdc = 40000;
  EXPECT_THROW(write_recording(folder / "toy.h5", recording), BadInput);
}

TEST(RecordingTest, TheFirstVersionWithoutBiotacsIsStillRead) {
  const TestFolder folder;
  const Recording written = toy_recording(20);
  write_recording(folder / "old.h5", with_biotacs(written));
  std::fstream(folder / "old.h5", std::ios::in | std::ios::out) << "PALPATE RECORDING 1\n";
  const Recording read = read_recording(folder / "old.h5");
  ASSERT_EQ(read.frames.size(), written.frames.size());
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    expect_same_frame(read.frames[i], written.frames[i]);
    EXPECT_TRUE(read.frames[i].reading.biotacs.empty());
  }
}

TEST(RecordingTest, KeepsWhatContactsTellOfTheirErrors) {
  const TestFolder folder;
  Recording written = toy_recording(120);
  written.header.sensor_reported_errors = true;
  RandomStream random(8, "errors");
  for (Frame& frame : written.frames) {
    for (auto& finger : frame.reading.contacts) {
      for (auto& contact : finger) {
        contact.point_sigma = random.uniform();
        contact.normal_sigma = random.uniform();
      }
    }
  }
  write_recording(folder / "errors.h5", written);
  const Recording read = read_recording(folder / "errors.h5");
  EXPECT_TRUE(read.header.sensor_reported_errors);
  ASSERT_EQ(read.frames.size(), written.frames.size());
  std::size_t contacts = 0;
  for (std::size_t i = 0; i < read.frames.size(); ++i) {
    expect_same_frame(read.frames[i], written.frames[i]);
    for (std::size_t k = 0; k < hand::kShadowFingers; ++k) {
      const auto &a = read.frames[i].reading.contacts[k],
                 &b = written.frames[i].reading.contacts[k];
      for (std::size_t c = 0; c < a.size(); ++c, ++contacts) {
        EXPECT_EQ(a[c].point_sigma, b[c].point_sigma);
        EXPECT_EQ(a[c].normal_sigma, b[c].normal_sigma);
      }
    }
  }
  EXPECT_GT(contacts, 0u);
}

std::string first_line(const std::filesystem::path& path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

TEST(RecordingTest, WritesTheNewestFormatWithAndWithoutErrorsOfContacts) {
  const TestFolder folder;
  for (const bool errors : {false, true}) {
    Recording recording = toy_recording(3);
    recording.header.sensor_reported_errors = errors;
    write_recording(folder / "toy.h5", recording);
    EXPECT_EQ(first_line(folder / "toy.h5"), "PALPATE RECORDING 4");
    EXPECT_EQ(read_recording(folder / "toy.h5").header.sensor_reported_errors, errors);
  }
}

TEST(RecordingTest, RefusesErrorsOfContactsThatTheHeaderDoesNotAnnounce) {
  const TestFolder folder;
  Recording recording = toy_recording(3);
  recording.frames[0].reading.contacts[1] = {{.p = Eigen::Vector3d::Zero(),
                                              .n = Eigen::Vector3d::UnitZ(),
                                              .f = -Eigen::Vector3d::UnitZ(),
                                              .normal_sigma = 0.1}};
  EXPECT_THROW(write_recording(folder / "toy.h5", recording), BadInput);
}

Recording one_contact_with_errors() {
  Recording recording = toy_recording(3);
  recording.header.sensor_reported_errors = true;
  for (Frame& frame : recording.frames) {
    for (auto& finger : frame.reading.contacts) finger.clear();
  }
  recording.frames[1].reading.contacts[1] = {{.p = Eigen::Vector3d::Zero(),
                                              .n = Eigen::Vector3d::UnitZ(),
                                              .f = -Eigen::Vector3d::UnitZ(),
                                              .point_sigma = 0.001,
                                              .normal_sigma = 0.1}};
  return recording;
}

/// Puts other errors of its only contact into a recording, and takes the checksum off it.
void overwrite_errors(const std::filesystem::path& path, int version,
                      std::array<double, 2> errors) {
  {
    const H5::H5File file(path.string(), H5F_ACC_RDWR);
    file.openDataSet("frames/contact_errors").write(errors.data(), H5::PredType::NATIVE_DOUBLE);
  }
  write_open_seal_of(path, version);
}

TEST(RecordingTest, RefusesErrorsOfContactsThatCannotBe) {
  const TestFolder folder;
  write_recording(folder / "good.h5", one_contact_with_errors());
  for (const int version : {3, 4}) {
    overwrite_errors(folder / "good.h5", version, {0.002, 0.1 * version});
    EXPECT_EQ(read_recording(folder / "good.h5").frames[1].reading.contacts[1][0].normal_sigma,
              0.1 * version);
  }
  for (const double bad : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const bool of_point : {true, false}) {
      Recording recording = one_contact_with_errors();
      write_recording(folder / "bad.h5", recording);
      overwrite_errors(folder / "bad.h5", 4, {of_point ? bad : 0.001, of_point ? 0.1 : bad});
      EXPECT_NE(message_of(folder / "bad.h5").find("contact_errors of contact 0 holds"),
                std::string::npos)
          << message_of(folder / "bad.h5");
      auto& contact = recording.frames[1].reading.contacts[1][0];
      (of_point ? contact.point_sigma : contact.normal_sigma) = bad;
      EXPECT_THROW(write_recording(folder / "bad.h5", recording), BadInput) << bad;
    }
  }
}

TEST(RecordingTest, TruthOverwrittenWithNanReadsAsAbsent) {
  const TestFolder folder;
  Recording recording = toy_recording(20);
  for (Frame& frame : recording.frames) {
    if (frame.truth) frame.truth->T_world_object.matrix().setConstant(std::nan(""));
  }
  write_recording(folder / "blind.h5", recording);
  for (const Frame& frame : read_recording(folder / "blind.h5").frames) {
    EXPECT_FALSE(frame.truth.has_value());
  }
}

TEST(RecordingTest, NamesWhatIsWrongWithAFile) {
  const TestFolder folder;
  EXPECT_NE(message_of(folder / "none.h5").find("none.h5: no such file"), std::string::npos);
  EXPECT_NE(message_of(folder / "").find("not a file"), std::string::npos);
  std::ofstream(folder / "part.h5.partial");
  EXPECT_NE(message_of(folder / "part.h5").find("can be read as "), std::string::npos);
  EXPECT_NE(message_of(folder / "part.h5").find("part.h5.partial"), std::string::npos);
  std::ofstream(folder / "empty.h5");
  EXPECT_NE(message_of(folder / "empty.h5").find("not a palpate recording"), std::string::npos);
  std::ofstream(folder / "text.h5") << std::string(4096, 'x');
  EXPECT_NE(message_of(folder / "text.h5").find("not a palpate recording"), std::string::npos);
  write_recording(folder / "toy.h5", toy_recording(3));
  std::fstream(folder / "toy.h5", std::ios::in | std::ios::out) << "PALPATE RECORDING 7\n";
  EXPECT_NE(message_of(folder / "toy.h5").find("format \"7\" is none of 1 to 4"),
            std::string::npos);
  EXPECT_NE(message_of(folder / std::string(300, 'x').c_str()).find("no such file"),
            std::string::npos);
}

TEST(RecordingTest, RefusesValuesThatAreNotFinite) {
  const TestFolder folder;
  Recording recording = toy_recording(9);
  recording.frames[5].reading.joints[3] = std::nan("");
  write_recording(folder / "nan.h5", recording);
  EXPECT_NE(message_of(folder / "nan.h5").find("frames/joints of frame 5 holds nan"),
            std::string::npos);

  recording = toy_recording(9);
  recording.estimates[0].modes[0].weight = std::nan("");
  EXPECT_THROW(write_recording(folder / "nan.h5", recording), BadInput);
  recording = toy_recording(9);
  recording.header.object.stable_poses[0].height = std::numeric_limits<double>::infinity();
  EXPECT_THROW(write_recording(folder / "nan.h5", recording), BadInput);
}

TEST(RecordingTest, RefusesAHandWhoseLinksDoNotExist) {
  const TestFolder folder;
  Recording recording = toy_recording(1);
  recording.header.hand.links[1].parent = 2;
  EXPECT_THROW(write_recording(folder / "toy.h5", recording), BadInput);
  recording = toy_recording(1);
  recording.header.hand.links[1].joint = hand::kShadowJoints;
  EXPECT_THROW(write_recording(folder / "toy.h5", recording), BadInput);
  recording = toy_recording(1);
  recording.header.object.mesh.triangles[4][1] = 99;
  write_recording(folder / "toy.h5", recording);
  EXPECT_NE(message_of(folder / "toy.h5").find("no vertex 99"), std::string::npos);
}

TEST(RecordingTest, RefusesAPathThatCannotBeWritten) {
  const TestFolder folder;
  const Recording recording = toy_recording(1);
  EXPECT_THROW(Writer(folder / "", recording.header), BadInput);
  EXPECT_THROW(Writer(folder / "no/such/folder/toy.h5", recording.header), BadInput);
}

TEST(RecordingTest, UnfinishedRecordingKeepsWhatWasFlushed) {
  const TestFolder folder;
  const Recording recording = toy_recording(250);
  {
    Writer writer(folder / "toy.h5", recording.header);
    for (const Frame& frame : recording.frames) writer.frame(frame);
    writer.event(recording.events[0]);
    writer.estimate(recording.estimates[0]);
    // As left by a program that dies here, and as seen by one that reads along.
    std::filesystem::copy_file(folder / "toy.h5.partial", folder / "dead.h5.partial");
    EXPECT_EQ(read_recording(folder / "toy.h5.partial").frames.size(), 200u);
  }
  EXPECT_NE(message_of(folder / "toy.h5").find("toy.h5.partial"), std::string::npos);
  const Recording closed = read_recording(folder / "toy.h5.partial");
  EXPECT_EQ(closed.frames.size(), 250u);
  const Recording dead = read_recording(folder / "dead.h5.partial");
  EXPECT_FALSE(dead.finished);
  ASSERT_EQ(dead.frames.size(), 200u);
  for (std::size_t i = 0; i < dead.frames.size(); ++i) {
    expect_same_frame(dead.frames[i], recording.frames[i]);
  }
  expect_same_events(dead.events, {recording.events[0]});
  ASSERT_EQ(dead.estimates.size(), 1u);
  expect_same_estimate(dead.estimates[0], recording.estimates[0]);
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
}

TEST(RecordingTest, FinishedRecordingDetectsEveryDamage) {
  const TestFolder folder;
  write_recording(folder / "toy.h5", toy_recording(120));
  const std::string whole = bytes_of(folder / "toy.h5");
  RandomStream random(11, "damage");
  for (int trial = 0; trial < 200; ++trial) {
    std::string bytes = whole;
    // The seal's padding (bytes 50..511) carries nothing.
    bytes[512 + random.index(bytes.size() - 512)] ^= static_cast<char>(1 + random.index(255));
    write_bytes(folder / "bad.h5", bytes);
    EXPECT_NE(message_of(folder / "bad.h5"), "");
    write_bytes(folder / "bad.h5", whole.substr(0, random.index(whole.size())));
    EXPECT_NE(message_of(folder / "bad.h5"), "");
  }
  for (std::size_t i = 0; i < 40; ++i) {
    std::string bytes = whole;
    bytes[i] ^= 1;
    write_bytes(folder / "bad.h5", bytes);
    EXPECT_NE(message_of(folder / "bad.h5"), "");
  }
}

TEST(RecordingTest, DamagedUnfinishedRecordingLoadsOrIsRefused) {
  const TestFolder folder;
  const Recording recording = toy_recording(220);
  Writer writer(folder / "toy.h5", recording.header);
  for (const Frame& frame : recording.frames) writer.frame(frame);
  for (const Event& event : recording.events) writer.event(event);
  const std::string whole = bytes_of(folder / "toy.h5.partial");
  RandomStream random(12, "damage");
  int refused = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::string bytes = whole;
    // Most of HDF5's own tables lie at the front, so half of the damage goes there.
    const std::size_t reach = trial % 2 ? bytes.size() : 8192;
    for (int flips = 0; flips < 1 + trial % 4; ++flips) {
      bytes[random.index(reach)] ^= static_cast<char>(1 + random.index(255));
    }
    write_bytes(folder / "bad.h5", trial % 5 ? bytes : whole.substr(0, random.index(whole.size())));
    refused += message_of(folder / "bad.h5").empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 100);
}

TEST(RecordingTest, MessagesAreOneLine) {
  const TestFolder folder;
  write_recording(folder / "toy.h5", toy_recording(3));
  const std::string whole = bytes_of(folder / "toy.h5");
  for (const std::size_t size : {0, 10, 100, 511, 600, 3000}) {
    write_bytes(folder / "bad.h5", whole.substr(0, size));
    EXPECT_EQ(message_of(folder / "bad.h5").find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::recording
