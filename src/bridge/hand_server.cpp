// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <deque>
#include <thread>

#include "bridge/hand_commands.hpp"
#include "bridge/stream_readers.hpp"
#include "bridge/wall_clock.hpp"
#include "palpate/bridge/hand_peer.hpp"

namespace palpate::bridge {
namespace {

constexpr double kStopPoll = 0.1;                  // s after which a request to stop is looked for
constexpr std::uint64_t kFuture = 60'000'000'000;  // ns that another clock may be ahead

}  // namespace

struct HandServer::Impl {
  Participant& participant;
  hand::Hand& hand;
  const hand::Description& description;
  ros2::RobotInterface interface;
  HandServerOptions options;
  RawReader joint_commands, position_commands, mount_commands;
  TopicWriter<ros2::JointState> joints, actuators;
  TopicWriter<ros2::WrenchStamped> wrench;
  TopicWriter<ros2::TFMessage> tf;
  std::deque<TopicWriter<ros2::PointCloud2>> contacts;
  std::uint64_t start_time, ticks = 0, messages = 0, malformed = 0;

  Impl(Participant& at, hand::Hand& served, const hand::Description& described,
       const ros2::RobotInterface& named, const CommandTopics& topics,
       const HandServerOptions& chosen)
      : participant(at),
        hand(served),
        description(described),
        interface(named),
        options(chosen),
        joint_commands(at, topics.joints, ros2::JointTrajectory::kType, {}),
        position_commands(at, topics.positions, ros2::Float64MultiArray::kType, {}),
        mount_commands(at, topics.mount, ros2::PoseStamped::kType, {}),
        joints(at, named.joint_states, sensor_qos()),
        actuators(at, named.actuator_states, sensor_qos()),
        wrench(at, named.wrench, sensor_qos()),
        tf(at, named.tf, sensor_qos()),
        start_time(wall_clock()) {
    for (const auto& finger : described.fingers) {
      contacts.emplace_back(at, named.contacts_of(finger), sensor_qos());
    }
  }

  /// Joint states last, as readings are made of what came before them.
  void publish(const hand::HandReading& reading) {
    const std::uint64_t time = start_time + ros2::nanoseconds_of(reading.time);
    const auto outgoing = ros2::messages_of(reading, description, interface, time);
    tf.write(outgoing.tf);
    for (std::size_t i = 0; i < contacts.size(); ++i) contacts[i].write(outgoing.contacts[i]);
    wrench.write(outgoing.wrench);
    actuators.write(outgoing.actuators);
    joints.write(outgoing.joints);
    messages += 4 + contacts.size();
  }

  hand::HandReading tick(const hand::HandCommand& command) {
    auto reading = hand.step(command);
    ++ticks;
    publish(reading);
    return reading;
  }

  /// Takes what has come, and reports of each what it asks for.
  void take(HandCommands& commands, const std::function<void(HandCommands::Effect)>& on_effect) {
    const auto from = [&](RawReader& reader, auto method) {
      reader.take([&](std::string_view cdr, std::uint64_t received) {
        ++messages;
        on_effect(method(cdr, received + kFuture));
      });
    };
    from(mount_commands,
         [&](auto cdr, std::uint64_t latest) { return commands.take_mount(cdr, latest); });
    from(joint_commands,
         [&](auto cdr, std::uint64_t latest) { return commands.take_joints(cdr, latest); });
    from(position_commands, [&](auto cdr, std::uint64_t) { return commands.take_positions(cdr); });
    malformed = commands.malformed();
  }
};

HandServer::HandServer(Participant& participant, hand::Hand& hand,
                       const hand::Description& description, const ros2::RobotInterface& interface,
                       const CommandTopics& topics, const HandServerOptions& options)
    : impl_(new Impl(participant, hand, description, interface, topics, options)) {}

HandServer::~HandServer() = default;

void HandServer::run(const hand::HandCommand& start, const std::stop_token& stop) {
  Impl& impl = *impl_;
  HandCommands commands(impl.description, start, impl.interface.world);
  hand::HandReading last = impl.tick(start);
  auto next = std::chrono::steady_clock::now();
  while (!stop.stop_requested()) {
    if (impl.options.real_time) {
      impl.take(commands, [](HandCommands::Effect) {});
      last = impl.tick(commands.command());
      next += std::chrono::duration_cast<std::chrono::steady_clock::duration>(
          std::chrono::duration<double>(hand::kTick));
      std::this_thread::sleep_until(next);
      continue;
    }
    impl.participant.wait(kStopPoll);
    impl.take(commands, [&](HandCommands::Effect effect) {
      if (effect == HandCommands::Effect::step) last = impl.tick(commands.command());
      if (effect == HandCommands::Effect::repeat) impl.publish(last);
    });
  }
}

std::uint64_t HandServer::ticks() const { return impl_->ticks; }
std::uint64_t HandServer::messages() const { return impl_->messages; }
std::uint64_t HandServer::malformed() const { return impl_->malformed; }

}  // namespace palpate::bridge
