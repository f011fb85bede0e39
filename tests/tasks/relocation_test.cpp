// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocation.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/temporary_folder.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/tasks/relocate/episode_recording.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "tasks/relocate/relocated_object.hpp"
#include "tasks/relocate/touch_recorder.hpp"

namespace palpate::relocate {
namespace {

std::unique_ptr<Policy> box_policy() { return load_policy(asset("models/relocate-box.json")); }

TaskOptions box_task() {
  TaskOptions task;
  task.object = "box";
  return task;
}

TEST(Relocation, FingertipsSenseTheSurfaceOfWhatTheyHold) {
  const auto model = make_model(box_task());
  const auto object = known_object(make_object(box_task()), model.object_mass());
  const geometry::MeshQuery surface(object.mesh);
  const auto policy = box_policy();
  const RelocateTouch touch(model, {0, 0, 0, 0, 0}, 1);
  const hand::Description& hand = touch.hand_model();
  RelocateTask task(model);
  int contacts = 0;
  const auto look = [&](int step) {
    const Eigen::Isometry3d T_world_object = object_pose(task.positions()) * object.T_mesh_object;
    const auto reading = touch.read(task, step);
    const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
    for (std::size_t finger = 0; finger < reading.contacts.size(); ++finger) {
      const Eigen::Isometry3d T_object_link =
          T_world_object.inverse() * reading.mount.pose() *
          T_mount_link[static_cast<std::size_t>(hand.fingers[finger].link)];
      for (const auto& contact : reading.contacts[finger]) {
        ++contacts;
        EXPECT_LT(std::abs(surface.signed_distance(T_object_link * contact.p)), 1e-3);
        EXPECT_LT(contact.f.dot(contact.n), 0);
      }
    }
  };
  run_episode(task, episode_start({}, 1, 0), 99, [&](int step, const PolicyInput& input) {
    if (step >= 60 && step % 10 == 0) look(step);  // it hangs at rest
    return policy->act(input);
  });
  EXPECT_GT(contacts, 8);
}

TEST(Relocation, ErrorsOfAnObservedPositionAreRefused) {
  RelocationOptions options;
  options.explore = false;
  const Relocation relocation(box_task(), options);
  EpisodeOptions biased, late;
  biased.object_bias = 0.01;
  late.observation_period = 0.1;
  for (const EpisodeOptions& episode : {biased, late}) {
    EXPECT_THROW(relocation.run(*box_policy(), episode, 71, 0), BadInput);
  }
}

/// One in six mugs is pushed away from a rough place: hence medians.
TEST(Relocation, TrackingInTheGraspMakesUpForARoughPlace) {
  constexpr std::size_t kStarts = 5;
  RelocationOptions options;
  options.explore = false;
  const auto policy = load_policy(asset("models/relocate-best.json"));
  const auto tracked = Relocation({}, options).run_all(*policy, {}, 71, kStarts, 2);
  options.tracking.estimate = false;
  const auto carried = Relocation({}, options).run_all(*policy, {}, 71, kStarts, 1);
  std::vector<double> estimates, tracked_errors, carried_errors;
  for (std::size_t i = 0; i < kStarts; ++i) {
    EXPECT_EQ(carried[i].estimates, 0);
    EXPECT_EQ(tracked[i].resting_error, carried[i].resting_error);
    EXPECT_LT(tracked[i].resting_error, 0.03);
    estimates.push_back(tracked[i].estimates);
    tracked_errors.push_back(tracked[i].reported_error);
    carried_errors.push_back(carried[i].reported_error);
  }
  EXPECT_GT(median(estimates), 3);
  EXPECT_LT(median(tracked_errors), 0.7 * median(carried_errors));
}

TEST(Relocation, ExploringEstimatesThePlace) {
  RelocationOptions options;
  options.exploring.touches = options.exploring.max_touches = 6;
  EpisodeOptions episode;
  episode.horizon = 2;
  const auto explored = Relocation(box_task(), options).run_all(*box_policy(), episode, 72, 5, 2);
  std::vector<double> errors;
  for (const auto& one : explored) {
    EXPECT_TRUE(one.explored);
    errors.push_back(one.resting_error);
  }
  EXPECT_LT(median(errors), 0.005);
}

TEST(Relocation, ARecordingIsEstimatedAgainBitForBit) {
  RelocationOptions options;
  options.explore = false;
  const auto policy = box_policy();
  const Relocation relocation(box_task(), options);
  recording::Recording recording;
  const auto recorded = relocation.run(*policy, {}, 74, 1, &recording);
  EXPECT_EQ(recorded.reported_error, relocation.run(*policy, {}, 74, 1).reported_error);
  ASSERT_GT(recorded.estimates, 3);
  EXPECT_EQ(recording.estimates.size(), static_cast<std::size_t>(recorded.estimates) + 1);
  EXPECT_EQ(recording.frames.size(), static_cast<std::size_t>(recorded.episode.steps));
  EXPECT_TRUE(is_episode(recording));

  const TemporaryFolder folder;
  const auto path = folder.path() / "episode.h5";
  recording::write_recording(path, recording);
  const auto read = recording::read_recording(path);
  const auto again = replay_episode(read, options);
  const auto& last = recording.estimates.back();
  ASSERT_EQ(again.posterior.modes.size(), last.modes.size());
  EXPECT_EQ(again.posterior.modes.front().T_frame_object.matrix(),
            last.modes.front().T_world_object.matrix());
  EXPECT_EQ(again.posterior.modes.front().weight, last.modes.front().weight);
  EXPECT_EQ(again.contacts.size(), last.contacts.size());

  auto other = options;
  other.tracking.translation_sigma *= 2;
  EXPECT_NE(replay_episode(read, other).posterior.modes.front().T_frame_object.matrix(),
            last.modes.front().T_world_object.matrix());
  EXPECT_THROW((void)replay_episode(record_episode(box_task(), *policy, {}, 74, 1), {}), BadInput);
}

// From the readings of the exploration, in the world in which the policy then carries.
TEST(Relocation, AnExploredEpisodeIsEstimatedAgainBitForBit) {
  RelocationOptions options;
  options.exploring.touches = options.exploring.max_touches = 4;
  options.exploring.refining = 2;
  EpisodeOptions episode;
  episode.horizon = 60;
  recording::Recording recording;
  const auto recorded =
      Relocation(box_task(), options).run(*box_policy(), episode, 76, 0, &recording);
  ASSERT_TRUE(recorded.explored);
  ASSERT_GT(recorded.estimates, 0);
  EXPECT_EQ(recording.frames.size(),  // and one before the first step
            static_cast<std::size_t>(1 + recorded.explore_steps + recorded.episode.steps));
  const TemporaryFolder folder;
  recording::write_recording(folder.path() / "episode.h5", recording);
  const auto read = recording::read_recording(folder.path() / "episode.h5");
  const auto again = replay_episode(read, options);
  const auto& last = recording.estimates.back();
  ASSERT_EQ(again.posterior.modes.size(), last.modes.size());
  EXPECT_EQ(again.posterior.modes.front().T_frame_object.matrix(),
            last.modes.front().T_world_object.matrix());

  auto other = options;
  other.resting.resting_tilt_sigma *= 3;
  EXPECT_NE(replay_episode(recording, other).posterior.modes.front().T_frame_object.matrix(),
            last.modes.front().T_world_object.matrix());
}

// The arm's lift does not reach over it: the episode goes on with the rough place.
TEST(Relocation, WhatIsTooTallIsNotExplored) {
  TaskOptions task;
  task.object = "bottle";
  EpisodeOptions episode;
  episode.horizon = 30;
  recording::Recording recording;
  const auto result = Relocation(task, {}).run(*box_policy(), episode, 77, 0, &recording);
  EXPECT_FALSE(result.explored);
  EXPECT_NE(result.exploration.find("unreachable: ARTy would be at"), std::string::npos)
      << result.exploration;
  EXPECT_EQ(result.episode.steps, 30);
  EXPECT_FALSE(explored_place(recording));
  EXPECT_GT(recording.estimates.front().modes.size(), 10u);  // any yaw
}

TEST(Relocation, AMalformedPlaceOfAnExplorationIsRefused) {
  recording::Recording recording;
  EXPECT_FALSE(explored_place(recording));
  const auto place_of = [&](const std::string& text) {
    recording.events = {{0, recording::EventKind::note, "explore", "rough place " + text}};
    return explored_place(recording);
  };
  EXPECT_EQ(*place_of("-0.05 1e-3"), Eigen::Vector2d(-0.05, 1e-3));
  for (const char* text : {"", "0.1", "nan 0", "0.1 0.2 0.3", "1e300 0", "x y"}) {
    EXPECT_THROW((void)place_of(text), BadInput) << text;
  }
}

// Contacts of an estimate are on the object where it truly is, but for the errors of the sensors.
TEST(Relocation, ARecordingHasPosesAndContactsInOneFrame) {
  RelocationOptions options;
  options.explore = false;
  recording::Recording recording;
  Relocation(box_task(), options).run(*box_policy(), {}, 75, 0, &recording);
  const geometry::MeshQuery surface(recording.header.object.mesh);
  std::vector<double> distances;
  for (const auto& estimate : recording.estimates) {
    const auto frame = std::ranges::find_if(
        recording.frames, [&](const auto& one) { return one.reading.time == estimate.time; });
    ASSERT_NE(frame, recording.frames.end());
    const Eigen::Isometry3d T_object_world = frame->truth->T_world_object.inverse();
    for (const auto& contact : estimate.contacts) {
      distances.push_back(std::abs(surface.signed_distance(T_object_world * contact.p)));
    }
  }
  ASSERT_GT(distances.size(), 8u);
  EXPECT_LT(median(distances), 0.006);
}

TEST(Relocation, ThreadsDoNotMatter) {
  RelocationOptions options;
  options.explore = false;
  EpisodeOptions episode;
  episode.horizon = 40;
  const Relocation relocation(box_task(), options);
  const auto one = relocation.run_all(*box_policy(), episode, 73, 3, 1);
  const auto many = relocation.run_all(*box_policy(), episode, 73, 3, 3);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_GT(one[i].estimates, 0);
    EXPECT_EQ(one[i].reported_error, many[i].reported_error);
    EXPECT_EQ(one[i].episode.total, many[i].episode.total);
  }
}

// The mug's parts overlap; outside of them and in its cavity that does not show.
TEST(Relocation, TheMugOfPartsIsASolid) {
  const auto model = make_model({});
  const auto object = known_object(make_object({}), model.object_mass());
  const geometry::MeshQuery surface(object.mesh);
  const auto distance = [&](const Eigen::Vector3d& p) {
    return surface.signed_distance(object.T_mesh_object.inverse() * p);
  };
  const Eigen::Vector3d axis(-0.0029, 0.0006, 0);
  EXPECT_NEAR(distance(axis + Eigen::Vector3d(-0.0429, 0, 0)), 0.010, 1e-4);  // from the wall
  EXPECT_NEAR(distance(axis + Eigen::Vector3d(-0.0197, 0, 0)), 0.010, 1e-4);  // in the cavity
  EXPECT_NEAR(distance(axis + Eigen::Vector3d(-0.0313, 0, 0)), -0.0016, 1e-4);
  EXPECT_NEAR(distance({0.0498, -0.0016, 0.003}), -0.0033, 1e-4);  // in the handle
}

TEST(Relocation, RefusesAnObjectThatDoesNotStand) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "leaning.obj";
  const Eigen::Isometry3d lean(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
  const auto mesh = geometry::transformed(lean, geometry::box_mesh({0.05, 0.06, 0.07}));
  std::string text;
  for (const auto& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) {
    text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  write_file_atomically(path, text);
  TaskOptions task;
  task.object = path.string();
  EXPECT_THROW(Relocation(task, {}), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
