// SPDX-License-Identifier: Apache-2.0
#include "palpate/bridge/hand_peer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "bridge/bridge_fixture.hpp"
#include "bridge/hand_commands.hpp"
#include "bridge/stream_readers.hpp"
#include "bridge/wall_clock.hpp"
#include "palpate/core/error.hpp"
#include "palpate/ros2/cdr.hpp"
#include "palpate/ros2/robot_messages.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::bridge {
namespace {

using Effect = HandCommands::Effect;

/// Does at once what it is commanded, and remembers it.
class ObedientHand : public hand::Hand {
 public:
  explicit ObedientHand(const hand::Description& hand) : reading_(hand::resting_reading(hand)) {}

  hand::HandReading step(const hand::HandCommand& command) override {
    commands_.push_back(command);
    reading_.time += hand::kTick;
    reading_.mount = command.mount;
    reading_.torques = command.positions;
    reading_.joints[0] = 0.001 * static_cast<double>(commands_.size());
    reading_.contacts[1] = {{{0.001, 0, 0}, {0, 0, 1}, {0, 0, -0.5}}};
    return reading_;
  }

  std::vector<hand::HandCommand> commands_;

 private:
  hand::HandReading reading_;
};

class HandPeer : public DdsTest {
 protected:
  hand::Description hand_ = recording::toy_hand();
  Participant here_{domain_}, there_{domain_};

  hand::HandCommand command(int i) const {
    auto command = hand::resting_command(hand_);
    for (auto& position : command.positions) position = 0.01 * i;
    command.mount.xyz = {0.001 * i, 0, 0.3};
    return command;
  }

  /// A served hand, until the end of its life.
  struct Served {
    ObedientHand hand;
    HandServer server;
    std::jthread thread;
    Served(Participant& at, const hand::Description& described, const hand::HandCommand& start)
        : hand(described),
          server(at, hand, described),
          thread([this, start](const std::stop_token& stop) { server.run(start, stop); }) {}
    ~Served() {
      thread.request_stop();
      thread.join();
    }
  };
};

TEST_F(HandPeer, EveryCommandIsOneTickAndItsReading) {
  Served served(there_, hand_, command(0));
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 20, .patience = 20, .connect = 60});
  constexpr int kSteps = 200;
  double before = -1;
  for (int i = 1; i <= kSteps; ++i) {
    const auto reading = remote.step(command(i));
    EXPECT_GT(reading.time, before);
    before = reading.time;
    EXPECT_EQ(reading.torques[0], 0.01 * i);
    EXPECT_TRUE(reading.mount.xyz.isApprox(command(i).mount.xyz, 1e-12));
    ASSERT_EQ(reading.contacts[1].size(), 1U);
    EXPECT_NEAR(reading.contacts[1][0].p.x(), 0.001, 1e-9);
  }
  EXPECT_EQ(served.hand.commands_.size(), 1U + kSteps);
  EXPECT_EQ(remote.counts().malformed + remote.counts().out_of_order, 0U);
}

TEST_F(HandPeer, PositionsOnTopicsOfOtherNamesCommandItToo) {
  const CommandTopics topics{"/a/joint_trajectory", "/a/commands", "/b/target"};
  ObedientHand hand(hand_);
  HandServer server(there_, hand, hand_, {}, topics);
  std::jthread thread([&](const std::stop_token& stop) { server.run(command(0), stop); });
  RemoteHand remote(here_, hand_, {}, topics,
                    {.timeout = 20, .patience = 20, .connect = 60, .positions = true});
  for (int i = 1; i <= 20; ++i) EXPECT_EQ(remote.step(command(i)).torques[0], 0.01 * i);
  EXPECT_EQ(remote.repeats(), 0U);
  EXPECT_EQ(server.malformed(), 0U);
}

/// As where robot and program find each other topic by topic, so that parts of an answer are lost.
TEST_F(HandPeer, PositionsAreSentAgainUntilAnAnswerIsWhole) {
  std::jthread robot([this](const std::stop_token& stop) {
    RawReader commands(there_, CommandTopics{}.positions, ros2::Float64MultiArray::kType, {});
    const ros2::RobotInterface interface;
    TopicWriter<ros2::JointState> joints(there_, interface.joint_states, sensor_qos());
    TopicWriter<ros2::TFMessage> tf(there_, interface.tf, sensor_qos());
    auto reading = hand::resting_reading(hand_);
    int heard = 0;
    while (!stop.stop_requested()) {
      there_.wait(0.1);
      commands.take([&](std::string_view, std::uint64_t) {
        reading.time += hand::kTick;
        const auto stamp = 1'000'000'000 + ros2::nanoseconds_of(reading.time);
        const auto answer = ros2::messages_of(reading, hand_, interface, stamp);
        if (++heard > 1) tf.write(answer.tf);
        joints.write(answer.joints);
      });
    }
  });
  RemoteHand remote(here_, hand_, {}, {}, {.patience = 0.01, .connect = 60, .positions = true});
  EXPECT_NO_THROW(remote.step(command(1)));
  EXPECT_GE(remote.counts().incomplete, 1U);
}

TEST_F(HandPeer, WhoDiesIsSilentAndIsTakenUpAgain) {
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 2, .patience = 0.5, .connect = 60});
  hand::HandReading last;
  {
    Served served(there_, hand_, command(0));
    for (int i = 1; i <= 3; ++i) last = remote.step(command(i));
  }
  const auto silent = remote.step(command(4));
  EXPECT_EQ(silent.time, last.time);
  EXPECT_EQ(silent.torques, last.torques);
  EXPECT_EQ(remote.repeats(), 1U);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 5; i < 10; ++i) EXPECT_EQ(remote.step(command(i)).time, last.time);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5))
      << "each has waited as long as the first";
  Served again(there_, hand_, command(0));
  hand::HandReading reading = silent;
  for (int i = 10; i < 3000 && reading.time == last.time; ++i) reading = remote.step(command(i));
  EXPECT_GT(reading.time, last.time);
}

/// It reports where it is, whether it is commanded or not.
TEST_F(HandPeer, AHandIsSensedWithoutACommand) {
  ObedientHand hand(hand_);
  HandServer server(there_, hand, hand_, {}, {}, {.real_time = true});
  std::jthread thread([&](const std::stop_token& stop) { server.run(command(400), stop); });
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 20, .patience = 0.5, .connect = 60});
  const auto sensed = remote.sense();
  ASSERT_TRUE(sensed);
  EXPECT_NEAR(sensed->mount.xyz.x(), 0.4, 1e-9);
  EXPECT_GT(remote.step(command(401)).time, sensed->time);
  thread.request_stop();
  thread.join();
  bool begun = false;
  for (const auto& commanded : hand.commands_) {
    begun = begun || commanded.mount.xyz.x() != 0.4;
    EXPECT_EQ(commanded.mount.xyz.x(), begun ? 0.401 : 0.4);
  }
}

/// What it reports of its start may be heard or not.
TEST_F(HandPeer, AHandThatReportsOnlyWhenItIsCommandedNeedNotBeSensed) {
  Served served(there_, hand_, command(0));
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 20, .patience = 20, .connect = 60});
  const auto start = remote.sense();
  EXPECT_EQ(start.value_or(hand::resting_reading(hand_)).mount.xyz.x(), 0);
  EXPECT_NEAR(remote.step(command(1)).mount.xyz.x(), 0.001, 1e-9);
  EXPECT_EQ(served.hand.commands_.size(), 2U);
}

/// A robot that is not commanded, whose messages are not those of the hand.
struct Stranger {
  std::uint64_t commands = 0;
  std::jthread thread;
  Stranger(Participant& at, const hand::Description& hand, const std::string& prefix,
           const std::function<void(ros2::ReadingMessages&)>& spoil)
      : thread([this, &at, &hand, prefix, spoil](const std::stop_token& stop) {
          const ros2::RobotInterface interface;
          RawReader targets(at, CommandTopics{}.mount, ros2::PoseStamped::kType, {});
          TopicWriter<ros2::JointState> joints(at, interface.joint_states, sensor_qos());
          TopicWriter<ros2::TFMessage> tf(at, interface.tf, sensor_qos());
          auto reading = hand::resting_reading(hand);
          while (!stop.stop_requested()) {
            reading.time += hand::kTick;
            const auto stamp = 1'000'000'000 + ros2::nanoseconds_of(reading.time);
            auto messages = ros2::messages_of(reading, hand, interface, stamp);
            for (std::string& name : messages.joints.name) name.insert(0, prefix);
            spoil(messages);
            tf.write(messages.tf);
            joints.write(messages.joints);
            at.wait(hand::kTick);
            targets.take([&](std::string_view, std::uint64_t) { ++commands; });
          }
        }) {}
  std::uint64_t commanded() {
    thread.request_stop();
    thread.join();
    return commands;
  }
};

/// Its arm may well hear the commands.
TEST_F(HandPeer, AHandOfOtherNamesIsNotCommandedAndNamed) {
  Stranger stranger(there_, hand_, "left_", [](ros2::ReadingMessages&) {});
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 0.05, .patience = 0.01, .connect = 5});
  std::string error;
  try {
    remote.step(command(0));
  } catch (const BadInput& thrown) {
    error = thrown.what();
  }
  const std::string first = hand_.joints.front().name;
  EXPECT_NE(error.find(fmt::format("nobody reports {} joints: {}", hand_.joints.size(), first)),
            std::string::npos)
      << error;
  EXPECT_EQ(stranger.commanded(), 0U);
}

TEST_F(HandPeer, AHandWhoseMountIsNotKnownIsNotCommanded) {
  Stranger stranger(there_, hand_, "",
                    [](ros2::ReadingMessages& messages) { messages.tf.transforms.clear(); });
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 0.05, .patience = 0.01, .connect = 5});
  EXPECT_THROW(remote.step(command(0)), BadInput);
  EXPECT_EQ(stranger.commanded(), 0U);
}

/// Controllers of trajectories refuse those that end in the past.
TEST_F(HandPeer, CommandsAreStampedByTheClock) {
  Served served(there_, hand_, command(0));
  RawReader commands(there_, CommandTopics{}.joints, ros2::JointTrajectory::kType, {});
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 20, .patience = 20, .connect = 60});
  remote.step(command(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // a skill thinks
  const std::uint64_t before = wall_clock();
  remote.step(command(2));
  std::uint64_t last = 0;
  for (int i = 0; i < 100 && last < before; ++i) {
    commands.take([&](std::string_view cdr, std::uint64_t) {
      const auto trajectory = ros2::deserialize<ros2::JointTrajectory>(cdr);
      last = std::max(last, ros2::nanoseconds_of(trajectory.header.stamp));
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_GE(last, before);
}

TEST_F(HandPeer, WithoutAHandTheFirstStepSaysSo) {
  RemoteHand remote(here_, hand_, {}, {}, {.timeout = 0.05, .patience = 0.01, .connect = 0.2});
  EXPECT_THROW(remote.step(command(0)), BadInput);
}

class CommandsTest : public testing::Test {
 protected:
  hand::Description hand_ = recording::toy_hand();
  HandCommands commands_{hand_, hand::resting_command(hand_)};

  std::string joints(std::int32_t sec, double position) const {
    ros2::JointTrajectory trajectory;
    trajectory.header.stamp.sec = sec;
    trajectory.joint_names = {hand_.actuators[2].name};
    trajectory.points.resize(1);
    trajectory.points[0].positions = {position};
    return ros2::serialize(trajectory);
  }
  static std::string mount(std::int32_t sec, double x) {
    ros2::PoseStamped target;
    target.header.stamp.sec = sec;
    target.pose.position.x = x;
    return ros2::serialize(target);
  }
};

TEST_F(CommandsTest, JointsAndMountOfOneStampAreOneCommand) {
  EXPECT_EQ(commands_.take_mount(mount(1, 0.5)), Effect::none);
  EXPECT_EQ(commands_.take_joints(joints(1, 0.25)), Effect::step);
  EXPECT_EQ(commands_.command().mount.xyz.x(), 0.5);
  EXPECT_EQ(commands_.command().positions[2], 0.25);
  EXPECT_EQ(commands_.take_joints(joints(2, 0.5)), Effect::none);
  EXPECT_EQ(commands_.take_mount(mount(2, 0.75)), Effect::step);  // in the other order
}

TEST_F(CommandsTest, RepeatedOnesAreKnownAndLateOnesDropped) {
  commands_.take_mount(mount(5, 0.5));
  commands_.take_joints(joints(5, 0.25));
  EXPECT_EQ(commands_.take_mount(mount(5, 0.5)), Effect::none);
  EXPECT_EQ(commands_.take_joints(joints(5, 0.25)), Effect::repeat);
  EXPECT_EQ(commands_.take_joints(joints(4, 0.75)), Effect::none);
  EXPECT_EQ(commands_.take_mount(mount(4, 0.75)), Effect::none);
  EXPECT_EQ(commands_.command().positions[2], 0.25);
  EXPECT_EQ(commands_.command().mount.xyz.x(), 0.5);
  EXPECT_EQ(commands_.malformed(), 0U);
}

TEST_F(CommandsTest, WhoNeverCommandsTheMountIsNotWaitedFor) {
  EXPECT_EQ(commands_.take_joints(joints(1, 0.25)), Effect::step);
  ros2::Float64MultiArray positions;
  positions.data.assign(static_cast<std::size_t>(hand_.actuator_count()), 0.125);
  EXPECT_EQ(commands_.take_positions(ros2::serialize(positions)), Effect::step);
  EXPECT_EQ(commands_.command().positions[3], 0.125);
}

TEST_F(CommandsTest, PositionsAndTheNextTargetOfTheMountAreOneCommand) {
  ros2::Float64MultiArray message;
  message.data.assign(static_cast<std::size_t>(hand_.actuator_count()), 0.125);
  const std::string positions = ros2::serialize(message);
  EXPECT_EQ(commands_.take_mount(mount(1, 0.5)), Effect::none);
  EXPECT_EQ(commands_.take_positions(positions), Effect::step);
  EXPECT_EQ(commands_.take_positions(positions), Effect::none);  // in the other order
  EXPECT_EQ(commands_.take_mount(mount(2, 0.75)), Effect::step);
  EXPECT_EQ(commands_.command().mount.xyz.x(), 0.75);
  EXPECT_EQ(commands_.take_mount(mount(3, 1)), Effect::none);
}

TEST_F(CommandsTest, WhatCannotBeIsCountedAndChangesNothing) {
  ros2::JointTrajectory unknown;
  unknown.joint_names = {"elbow"};
  unknown.points.resize(1);
  unknown.points[0].positions = {1};
  ros2::Float64MultiArray few;
  few.data = {1, 2};
  ros2::PoseStamped turned;
  turned.pose.orientation = {0, 0, 0, 0};
  EXPECT_EQ(commands_.take_joints(ros2::serialize(unknown)), Effect::none);
  EXPECT_EQ(commands_.take_joints(ros2::serialize(ros2::JointTrajectory{})), Effect::none);
  EXPECT_EQ(commands_.take_joints(joints(1, std::nan(""))), Effect::none);
  EXPECT_EQ(commands_.take_joints("garbage"), Effect::none);
  EXPECT_EQ(commands_.take_positions(ros2::serialize(few)), Effect::none);
  EXPECT_EQ(commands_.take_mount(ros2::serialize(turned)), Effect::none);
  EXPECT_EQ(commands_.malformed(), 6U);
  EXPECT_EQ(commands_.command().positions, hand::resting_command(hand_).positions);
}

/// What comes after one that was believed would be late for good.
TEST_F(CommandsTest, AStampOfTheFutureIsNotBelieved) {
  constexpr std::uint64_t kLatest = 5'000'000'000;  // ns
  EXPECT_EQ(commands_.take_joints(joints(9, 0.5), kLatest), Effect::none);
  EXPECT_EQ(commands_.take_mount(mount(9, 0.5), kLatest), Effect::none);
  EXPECT_EQ(commands_.malformed(), 2U);
  EXPECT_EQ(commands_.take_joints(joints(5, 0.25), kLatest), Effect::step);
  EXPECT_EQ(commands_.command().positions[2], 0.25);
}

TEST_F(CommandsTest, AStampOfZeroIsTheTimeOfArrival) {
  EXPECT_EQ(commands_.take_joints(joints(0, 0.25)), Effect::step);
  EXPECT_EQ(commands_.command().positions[2], 0.25);
  EXPECT_EQ(commands_.take_mount(mount(0, 0.5)), Effect::step);
  EXPECT_EQ(commands_.command().mount.xyz.x(), 0.5);
  EXPECT_EQ(commands_.take_joints(joints(0, 0.5)), Effect::step);  // again and again
  EXPECT_EQ(commands_.command().positions[2], 0.5);
}

TEST_F(CommandsTest, ATargetOfTheMountInAnotherFrameIsCounted) {
  ros2::PoseStamped target;
  target.header = {{1, 0}, "palm"};
  target.pose.position.x = 0.5;
  EXPECT_EQ(commands_.take_mount(ros2::serialize(target)), Effect::none);
  EXPECT_EQ(commands_.malformed(), 1U);
  EXPECT_EQ(commands_.command().mount.xyz.x(), 0);
  target.header.frame_id = "world";
  commands_.take_mount(ros2::serialize(target));
  EXPECT_EQ(commands_.command().mount.xyz.x(), 0.5);
}

}  // namespace
}  // namespace palpate::bridge
