// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/episode_recording.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/simulation/hand/mjcf_hand.hpp"
#include "palpate/tasks/relocate/relocate_touch.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

TaskOptions fast(const std::string& object = "mug") {
  TaskOptions task;
  task.object = object;
  task.solver = "fast";
  return task;
}

/// A point on each finger, in the palm's frame: the origin of its last link.
Eigen::Matrix3Xd last_links(const char* mjcf, const std::string& prefix,
                            const std::vector<double>& joints) {
  simulation::MjcfHand hand(asset(mjcf), prefix + "palm");
  std::vector<hand::HandPoint> points;
  for (const char* finger : {"ff", "mf", "rf", "lf", "th"}) {
    points.push_back(hand.point(prefix + finger + "distal"));
  }
  return hand.evaluate(Eigen::VectorXd::Map(joints.data(), std::ssize(joints)), points).positions;
}

/// Angles of a hand's own joints below the palm, in its order, by their names.
std::vector<double> shadow_order(const hand::JointVector& joints) {
  const simulation::MjcfHand hand(asset("shadow_hand/right_hand.xml"), "rh_palm");
  std::vector<double> result;
  for (const auto& name : hand.joint_names()) {
    if (name.find("WRJ") != std::string::npos) {
      result.push_back(0);
    } else {
      result.push_back(joints[hand::shadow_hand().joint(name.substr(3))]);
    }
  }
  return result;
}

TEST(EpisodeRecording, TheShadowHandStandsAsTheAdroitHandDoes) {
  RandomStream random(3);
  for (int trial = 0; trial < 20; ++trial) {
    RelocateJoints q = RelocateJoints::Zero();
    for (Eigen::Index i = 8; i < q.size(); ++i) q[i] = random.uniform(-0.4, 0.6);
    const simulation::MjcfHand adroit(asset("adroit_hand/adroit_relocate.xml"), "palm");
    const auto fingers = adroit.joint_names().size();
    const std::vector<double> below(q.data() + q.size() - 22, q.data() + q.size());
    std::vector<double> own(fingers - below.size(), 0.0);  // the wrist, where it counts
    own.insert(own.end(), below.begin(), below.end());
    const auto expected = last_links("adroit_hand/adroit_relocate.xml", "", own);
    const auto drawn =
        last_links("shadow_hand/right_hand.xml", "rh_", shadow_order(shadow_joints(q)));
    // The little finger's metacarpal is 2 mm and turned otherwise in the two files.
    EXPECT_LT((expected - drawn).colwise().norm().head(3).maxCoeff(), 2e-3);
    EXPECT_LT((expected - drawn).col(4).norm(), 2e-3);
    EXPECT_LT((expected - drawn).col(3).norm(), 15e-3);
  }
}

TEST(EpisodeRecording, ReportsWhatHappenedAndCanBeReadBack) {
  EpisodeOptions episode;
  episode.horizon = 6;
  const auto recording = record_episode(fast(), structured(false), episode, 7, 2);
  ASSERT_EQ(recording.frames.size(), 7u);
  EXPECT_DOUBLE_EQ(recording.frames.back().reading.time, 0.06);
  const auto start = episode_start(episode, 7, 2);
  const Eigen::Vector3d object = recording.frames.front().truth->T_world_object.translation();
  EXPECT_NEAR((object.head<2>() - start.object).norm(), 0, 1e-9);
  ASSERT_EQ(recording.events.size(), 3u);  // the target; reach begins and ends
  EXPECT_EQ(recording.events[0].text.rfind("target ", 0), 0u);
  EXPECT_EQ(recording.events[1].phase, "reach");

  const auto path = std::filesystem::path(testing::TempDir()) / "episode.h5";
  recording::write_recording(path, recording);
  const auto read = recording::read_recording(path);
  EXPECT_EQ(read.frames.size(), recording.frames.size());
  EXPECT_EQ(read.header.object.mesh.triangles.size(),
            recording.header.object.mesh.triangles.size());
  std::filesystem::remove(path);
}

TEST(EpisodeRecording, ThePalmIsWhereTheTaskHasIt) {
  EpisodeOptions episode;
  episode.horizon = 4;
  const auto task = fast("box");
  const auto recording = record_episode(task, structured(false), episode, 1, 0);
  const auto& reading = recording.frames.front().reading;
  const auto links = hand::forward_kinematics(recording.header.hand, reading.joints);
  const Eigen::Isometry3d palm =
      reading.mount.pose() * links[static_cast<std::size_t>(recording.header.hand.palm)];
  // Where the hand's file puts the palm.
  EXPECT_NEAR((palm.translation() - Eigen::Vector3d(0, -0.27, 0.20)).norm(), 0, 2e-3);
}

TEST(EpisodeRecording, TheObjectHasTheMassOfTheTask) {
  EpisodeOptions episode;
  episode.horizon = 1;
  TaskOptions task = fast("box");
  const double mass = record_episode(task, structured(false), episode, 1, 0).header.object.mass;
  task.mass_scale = 1.5;
  const auto heavy = record_episode(task, structured(false), episode, 1, 0);
  EXPECT_NEAR(heavy.header.object.mass, 1.5 * mass, 1e-9);
}

TEST(EpisodeRecording, RefusesAnUnknownObject) {
  EXPECT_THROW(record_episode(fast("nothing.stl"), structured(false), {}, 1, 0), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
