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
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

template <class Value>
void expect_same(const Value& a, const Value& b) {
  EXPECT_EQ(a, b);
}

void expect_same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  EXPECT_EQ(a.matrix(), b.matrix());
}

void expect_same_object(const geometry::KnownObject& a, const geometry::KnownObject& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  expect_same(a.T_mesh_object, b.T_mesh_object);
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.mass_properties.volume, b.mass_properties.volume);
  EXPECT_EQ(a.mass_properties.centroid, b.mass_properties.centroid);
  EXPECT_EQ(a.mass_properties.inertia, b.mass_properties.inertia);
  EXPECT_EQ(a.symmetries, b.symmetries);
  EXPECT_EQ(a.repairs, b.repairs);
  ASSERT_EQ(a.stable_poses.size(), b.stable_poses.size());
  for (std::size_t i = 0; i < a.stable_poses.size(); ++i) {
    EXPECT_EQ(a.stable_poses[i].R_table_object, b.stable_poses[i].R_table_object);
    EXPECT_EQ(a.stable_poses[i].height, b.stable_poses[i].height);
    EXPECT_EQ(a.stable_poses[i].probability, b.stable_poses[i].probability);
  }
}

void expect_same_hand(const hand::Description& a, const hand::Description& b) {
  ASSERT_EQ(a.links.size(), b.links.size());
  for (std::size_t i = 0; i < a.links.size(); ++i) {
    EXPECT_EQ(a.links[i].name, b.links[i].name);
    EXPECT_EQ(a.links[i].parent, b.links[i].parent);
    expect_same(a.links[i].T_parent_link, b.links[i].T_parent_link);
    EXPECT_EQ(a.links[i].axis, b.links[i].axis);
    EXPECT_EQ(a.links[i].joint, b.links[i].joint);
  }
  EXPECT_EQ(a.palm, b.palm);
  EXPECT_EQ(a.kinematic_error, b.kinematic_error);
  EXPECT_EQ(a.distal, b.distal);
  for (std::size_t i = 0; i < hand::kShadowFingers; ++i) {
    EXPECT_EQ(a.tips[i].a, b.tips[i].a);
    EXPECT_EQ(a.tips[i].b, b.tips[i].b);
    EXPECT_EQ(a.tips[i].radius, b.tips[i].radius);
  }
  ASSERT_EQ(a.spheres.size(), b.spheres.size());
  for (std::size_t i = 0; i < a.spheres.size(); ++i) {
    EXPECT_EQ(a.spheres[i].link, b.spheres[i].link);
    EXPECT_EQ(a.spheres[i].center, b.spheres[i].center);
    EXPECT_EQ(a.spheres[i].radius, b.spheres[i].radius);
  }
}

void expect_same_reading(const hand::HandReading& a, const hand::HandReading& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.joints, b.joints);
  EXPECT_EQ(a.torques, b.torques);
  EXPECT_EQ(a.base.xyz, b.base.xyz);
  EXPECT_EQ(a.base.ypr, b.base.ypr);
  EXPECT_EQ(a.base_force, b.base_force);
  for (std::size_t finger = 0; finger < hand::kShadowFingers; ++finger) {
    ASSERT_EQ(a.contacts[finger].size(), b.contacts[finger].size());
    for (std::size_t i = 0; i < a.contacts[finger].size(); ++i) {
      EXPECT_EQ(a.contacts[finger][i].p, b.contacts[finger][i].p);
      EXPECT_EQ(a.contacts[finger][i].n, b.contacts[finger][i].n);
      EXPECT_EQ(a.contacts[finger][i].f, b.contacts[finger][i].f);
    }
  }
}

void expect_same_frame(const Frame& a, const Frame& b) {
  expect_same_reading(a.reading, b.reading);
  EXPECT_EQ(a.command.positions, b.command.positions);
  EXPECT_EQ(a.command.base.xyz, b.command.base.xyz);
  EXPECT_EQ(a.command.base.ypr, b.command.base.ypr);
  ASSERT_EQ(a.truth.has_value(), b.truth.has_value());
  if (!a.truth) return;
  expect_same(a.truth->T_world_object, b.truth->T_world_object);
  EXPECT_EQ(a.truth->joints, b.truth->joints);
}

void expect_same_estimate(const EstimateRecord& a, const EstimateRecord& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.status, b.status);
  ASSERT_EQ(a.modes.size(), b.modes.size());
  for (std::size_t i = 0; i < a.modes.size(); ++i) {
    expect_same(a.modes[i].T_world_object, b.modes[i].T_world_object);
    EXPECT_EQ(a.modes[i].weight, b.modes[i].weight);
    EXPECT_EQ(a.modes[i].covariance, b.modes[i].covariance);
    ASSERT_EQ(a.modes[i].free_axis.has_value(), b.modes[i].free_axis.has_value());
    if (!a.modes[i].free_axis) continue;
    EXPECT_EQ(a.modes[i].free_axis->point, b.modes[i].free_axis->point);
    EXPECT_EQ(a.modes[i].free_axis->direction, b.modes[i].free_axis->direction);
    EXPECT_EQ(a.modes[i].free_axis->extent, b.modes[i].free_axis->extent);
  }
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    EXPECT_EQ(a.contacts[i].finger, b.contacts[i].finger);
    EXPECT_EQ(a.contacts[i].time, b.contacts[i].time);
    EXPECT_EQ(a.contacts[i].p, b.contacts[i].p);
    EXPECT_EQ(a.contacts[i].n, b.contacts[i].n);
    EXPECT_EQ(a.contacts[i].f, b.contacts[i].f);
    EXPECT_EQ(a.contacts[i].point_sigma, b.contacts[i].point_sigma);
    EXPECT_EQ(a.contacts[i].normal_sigma, b.contacts[i].normal_sigma);
  }
}

void expect_same_events(const std::vector<Event>& a, const std::vector<Event>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].time, b[i].time);
    EXPECT_EQ(a[i].kind, b[i].kind);
    EXPECT_EQ(a[i].phase, b[i].phase);
    EXPECT_EQ(a[i].text, b[i].text);
  }
}

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
    EXPECT_EQ(read.header.program_version, written.header.program_version);
    EXPECT_EQ(read.header.seed, written.header.seed);
    EXPECT_EQ(read.header.config_toml, written.header.config_toml);
    expect_same_object(read.header.object, written.header.object);
    expect_same_hand(read.header.hand, written.header.hand);
    ASSERT_EQ(read.frames.size(), written.frames.size());
    for (std::size_t i = 0; i < read.frames.size(); ++i) {
      expect_same_frame(read.frames[i], written.frames[i]);
    }
    expect_same_events(read.events, written.events);
    ASSERT_EQ(read.estimates.size(), written.estimates.size());
    for (std::size_t i = 0; i < read.estimates.size(); ++i) {
      expect_same_estimate(read.estimates[i], written.estimates[i]);
    }
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
  written.header.own_errors = true;
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
  EXPECT_TRUE(read.header.own_errors);
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

TEST(RecordingTest, OnlyErrorsOfContactsNeedTheNewFormat) {
  const TestFolder folder;
  Recording recording = toy_recording(3);
  write_recording(folder / "toy.h5", recording);
  EXPECT_EQ(first_line(folder / "toy.h5"), "PALPATE RECORDING 2");
  recording.header.own_errors = true;
  write_recording(folder / "errors.h5", recording);
  EXPECT_EQ(first_line(folder / "errors.h5"), "PALPATE RECORDING 3");
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
  recording.header.own_errors = true;
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
void overwrite_errors(const std::filesystem::path& path, std::array<double, 2> errors) {
  {
    const H5::H5File file(path.string(), H5F_ACC_RDWR);
    file.openDataSet("frames/contact_errors").write(errors.data(), H5::PredType::NATIVE_DOUBLE);
  }
  std::string seal = "PALPATE RECORDING 3\nunfinished\n";
  seal.resize(512);
  std::fstream(path, std::ios::in | std::ios::out | std::ios::binary) << seal;
}

TEST(RecordingTest, RefusesErrorsOfContactsThatCannotBe) {
  const TestFolder folder;
  write_recording(folder / "good.h5", one_contact_with_errors());
  overwrite_errors(folder / "good.h5", {0.002, 0.2});
  EXPECT_EQ(read_recording(folder / "good.h5").frames[1].reading.contacts[1][0].normal_sigma, 0.2);
  for (const double bad : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const bool of_point : {true, false}) {
      Recording recording = one_contact_with_errors();
      write_recording(folder / "bad.h5", recording);
      overwrite_errors(folder / "bad.h5", {of_point ? bad : 0.001, of_point ? 0.1 : bad});
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
  std::ofstream(folder / "empty.h5");
  EXPECT_NE(message_of(folder / "empty.h5").find("not a palpate recording"), std::string::npos);
  std::ofstream(folder / "text.h5") << std::string(4096, 'x');
  EXPECT_NE(message_of(folder / "text.h5").find("not a palpate recording"), std::string::npos);
  write_recording(folder / "toy.h5", toy_recording(3));
  std::fstream(folder / "toy.h5", std::ios::in | std::ios::out) << "PALPATE RECORDING 7\n";
  EXPECT_NE(message_of(folder / "toy.h5").find("format \"7\" is none of 1 to 3"),
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
