// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "hand/descriptions.hpp"
#include "palpate/core/random.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// A folder of the test's own, removed with all that it holds.
class TestFolder {
 public:
  TestFolder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("palpate_recording_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline geometry::TriangleMesh box_mesh(const Eigen::Vector3d& half) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                               i & 4 ? half.z() : -half.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A palm with one finger of two links; all five fingertips of the Shadow hand are that finger's.
inline hand::Description toy_hand() {
  hand::Description hand = hand::shadow_on_link(2, {{0, 0, 0.01}, {0, 0, 0.02}, 0.008});
  const Eigen::Isometry3d along(Eigen::Translation3d(0, 0, 0.05));
  hand.links = {{"palm", -1, Eigen::Isometry3d::Identity(), Eigen::Vector3d::UnitX(), 0},
                {"middle", 0, along, Eigen::Vector3d::UnitX(), 9},
                {"distal", 1, along, Eigen::Vector3d::UnitX(), 10}};
  hand.palm = 0;
  for (int link = 0; link < 3; ++link) hand.spheres.push_back({link, {0, 0, 0.02}, 0.012});
  return hand;
}

inline RecordingHeader toy_header(RandomStream& random) {
  RecordingHeader header;
  header.program_version = "1.2.3";
  header.seed = 0xfedcba9876543210u;
  header.config_toml = "seed = 7\nname = \"box\"\n";
  header.object.name = "box";
  header.object.mesh = box_mesh({0.025, 0.047, 0.0875});
  header.object.T_mesh_object = Eigen::Translation3d(random.normal3()) *
                                Eigen::Isometry3d(Eigen::Quaterniond(random.rotation()));
  header.object.mass = 0.4;
  header.object.mass_properties = {0.00082, random.normal3(), random.rotation()};
  header.object.stable_poses = {{random.rotation(), 0.0875, 0.7}, {random.rotation(), 0.025, 0.3}};
  header.object.symmetries = {Eigen::Matrix3d::Identity(),
                              Eigen::Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix()};
  header.object.repairs = {"merged 3 vertices"};
  return header;
}

inline Frame toy_frame(const hand::Description& hand, int tick, RandomStream& random) {
  Frame frame{
      .reading = hand::resting_reading(hand), .command = hand::resting_command(hand), .truth = {}};
  frame.reading.time = tick * hand::kTick;
  for (auto& joint : frame.reading.joints) joint = 0.1 * random.normal();
  for (auto& torque : frame.reading.torques) torque = random.normal();
  frame.reading.mount = {{0.001 * tick, 0, 0.2}, random.normal3()};
  frame.reading.mount_force = random.normal3();
  for (auto& finger : frame.reading.contacts) {
    for (std::size_t i = random.index(4); i > 0; --i) {
      finger.push_back({0.01 * random.normal3(), random.unit_vector(), random.normal3()});
    }
  }
  for (auto& position : frame.command.positions) position = random.normal();
  frame.command.mount = {random.normal3(), random.normal3()};
  if (tick % 7 != 3) {
    frame.truth.emplace();
    frame.truth->T_world_object = Eigen::Translation3d(0.001 * tick, 0, 0.0875) *
                                  Eigen::Isometry3d(Eigen::Quaterniond(random.rotation()));
    frame.truth->joints = frame.reading.joints;
  }
  return frame;
}

inline EstimateRecord toy_estimate(double time, RandomStream& random) {
  EstimateRecord estimate = {.time = time, .status = "ambiguous", .modes = {}, .contacts = {}};
  for (const double weight : {0.75, 0.25}) {
    PoseModeRecord mode;
    mode.T_world_object = Eigen::Translation3d(0.01 * random.normal3()) *
                          Eigen::Isometry3d(Eigen::Quaterniond(random.rotation()));
    mode.weight = weight;
    for (auto& value : mode.covariance.reshaped()) value = random.normal();
    estimate.modes.push_back(mode);
  }
  estimate.modes[1].free_axis = {random.normal3(), random.unit_vector(), std::numbers::pi, 0.3};
  estimate.contacts.push_back({2, time, random.normal3(), random.unit_vector(), random.normal3()});
  return estimate;
}

/// A recording of random values in every field.
inline Recording toy_recording(int ticks, const hand::Description& hand = toy_hand()) {
  RandomStream random(5, "toy recording");
  Recording recording;
  recording.header = toy_header(random);
  recording.header.hand = hand;
  for (int tick = 0; tick < ticks; ++tick)
    recording.frames.push_back(toy_frame(hand, tick, random));
  const double end = ticks * hand::kTick;
  recording.events = {{0, EventKind::begin, "height_probe", ""},
                      {end / 2, EventKind::note, "height_probe", "a \"quoted\" line\nand another"},
                      {end / 2, EventKind::end, "height_probe", "81 mm tall: side grasp"},
                      {end / 2, EventKind::begin, "grasp", ""},
                      {end, EventKind::end, "grasp", "4 fingers"}};
  recording.estimates = {toy_estimate(end / 2, random), toy_estimate(end, random)};
  return recording;
}

/// Seals a recording as one of that version whose writing has not ended.
inline void write_open_seal_of(const std::filesystem::path& path, int version) {
  std::string seal = fmt::format("PALPATE RECORDING {}\nunfinished\n", version);
  seal.resize(512);
  std::fstream(path, std::ios::in | std::ios::out | std::ios::binary) << seal;
}

}  // namespace palpate::recording
