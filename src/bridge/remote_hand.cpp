// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>
#include <set>

#include "bridge/stream_readers.hpp"
#include "bridge/wall_clock.hpp"
#include "palpate/bridge/hand_peer.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "palpate/ros2/messages/std_msgs.hpp"
#include "palpate/ros2/messages/trajectory_msgs.hpp"

namespace palpate::bridge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMatchPoll = 0.02;  // s after which it is seen again who is there
constexpr double kSettle = 0.25;  // s between first commands, and in which first readings come in

constexpr std::size_t kNamedJoints = 4;  // of those that nobody reports, at most

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct JointMessage {
  std::string cdr;
  std::uint64_t time = 0, received = 0;
};

}  // namespace

struct RemoteHand::Impl {
  Participant& participant;
  const hand::Description& hand;
  ros2::RobotInterface interface;
  RemoteHandOptions options;
  ros2::ReadingStream stream;
  std::deque<RawReader> readers;
  std::optional<TopicWriter<ros2::JointTrajectory>> joints;
  std::optional<TopicWriter<ros2::Float64MultiArray>> positions;  // in their place
  TopicWriter<ros2::PoseStamped> mount;
  std::deque<JointMessage> waiting;  // joint states, the other parts of which may be on their way
  std::optional<hand::HandReading> last;
  std::set<std::string> reported;  // joints of the hand, whatever else their messages lack
  std::uint64_t stamp = 0;         // of the last command
  std::uint64_t received = 0, repeats = 0;
  bool sensed = false;     // whether the hand reports unasked is known
  bool commanded = false;  // the first command was answered
  bool silent = false;     // the last step has waited in vain

  Impl(Participant& at, const hand::Description& described, const ros2::RobotInterface& named,
       const CommandTopics& topics, const RemoteHandOptions& chosen)
      : participant(at),
        hand(described),
        interface(named),
        options(chosen),
        stream(described, named),
        mount(at, topics.mount) {
    if (options.positions) {
      positions.emplace(at, topics.positions);
    } else {
      joints.emplace(at, topics.joints);
    }
    add_stream_readers(participant, hand, interface, readers);
  }

  void send(const hand::HandCommand& command) {
    const ros2::Time time = ros2::stamp_of(stamp);
    mount.write({{time, interface.world}, ros2::pose_of(command.mount.pose())});
    if (positions) {
      positions->write({{}, {command.positions.begin(), command.positions.end()}});
    } else {
      joints->write(trajectory_of(command, time));
    }
  }

  ros2::JointTrajectory trajectory_of(const hand::HandCommand& command,
                                      const ros2::Time& time) const {
    ros2::JointTrajectory trajectory;
    trajectory.header = {time, interface.mount};
    for (const auto& actuator : hand.actuators) trajectory.joint_names.push_back(actuator.name);
    ros2::JointTrajectoryPoint point;
    point.positions.assign(command.positions.begin(), command.positions.end());
    point.time_from_start = {0, static_cast<std::uint32_t>(1e9 * hand::kTick)};
    trajectory.points.push_back(point);
    return trajectory;
  }

  /// By the clock, as controllers refuse what is of the past; and later than all before.
  void stamp_next() { stamp = std::max(stamp + 1, wall_clock()); }

  /// Where the hand stands, if it says so unasked; nothing of one that reports only when it is
  /// commanded. Nobody is commanded whose readings cannot be heard, or are not whole.
  std::optional<hand::HandReading> standing() {
    const auto start = Clock::now();
    auto quiet = start;
    while (seconds_since(start) < options.connect) {
      const std::uint64_t before = received;
      if (auto reading = await(kMatchPoll)) return reading;
      if (received > before || readers.back().senders() == 0) quiet = Clock::now();
      if (seconds_since(quiet) >= kSettle) return std::nullopt;
    }
    throw no_hand();
  }

  BadInput no_hand() const {
    const std::string refused = refused_topics(readers);
    return BadInput(fmt::format(
        "no hand within {} s: {} messages came, {} joint states without all joints or the place "
        "of the mount, {} malformed {}{}{}",
        options.connect, received, stream.counts().incomplete, stream.counts().malformed,
        stream.counts().last_error, unreported(),
        refused.empty() ? "" : "; senders that are best effort: " + refused));
  }

  /// Joints of the hand that no message holds, in words: as of other names.
  std::string unreported() const {
    std::string names;
    std::size_t count = 0;
    for (const auto& joint : hand.joints) {
      if (reported.contains(joint.name) || ++count > kNamedJoints) continue;
      names += (names.empty() ? "" : ", ") + joint.name;
    }
    if (count == 0) return {};
    const std::string more = count > kNamedJoints ? ", ..." : "";
    return fmt::format("; nobody reports {} joints: {}{}", count, names, more);
  }

  /// Positions have no stamp, by which a command that comes twice were known: they are sent when
  /// there is somebody who hears them.
  void await_listeners() {
    const auto start = Clock::now();
    const auto waits = [&](bool heard, double limit) {
      return !heard && seconds_since(start) < limit;
    };
    while (positions && (waits(positions->readers() > 0, options.connect) ||
                         waits(mount.readers() > 0, std::min(kSettle, options.connect)))) {
      participant.wait(kMatchPoll);
      receive();
    }
  }

  /// Positions for as long as none was answered: the first is where the hand is, and does no harm
  /// if it comes twice.
  void send_again(const hand::HandCommand& command) {
    if (!positions || !commanded) send(command);
  }

  void receive() {
    for (RawReader& reader : readers) {
      reader.take([&](std::string_view cdr, std::uint64_t now) {
        ++received;
        if (reader.topic() != interface.joint_states) {
          stream.take(reader.topic(), reader.type(), cdr, now);
        } else {
          hold_back(cdr, now);
        }
      });
    }
  }

  void hold_back(std::string_view cdr, std::uint64_t now) {
    try {
      const auto state = ros2::deserialize<ros2::JointState>(cdr);
      if (!last) note_names(state.name);
      waiting.push_back({std::string(cdr), ros2::nanoseconds_of(state.header.stamp), now});
    } catch (const BadInput&) {
      stream.take(interface.joint_states, ros2::JointState::kType, cdr, now);  // counts it
    }
  }

  void note_names(const std::vector<std::string>& names) {
    for (const auto& joint : hand.joints) {
      if (std::ranges::find(names, joint.name) != names.end()) reported.insert(joint.name);
    }
  }

  /// The latest reading that is complete, or has waited long enough.
  std::optional<hand::HandReading> latest(bool patient) {
    std::optional<hand::HandReading> newest;
    while (!waiting.empty()) {
      const JointMessage& first = waiting.front();
      if (patient && !stream.has_all_since(first.time)) break;
      auto reading =
          stream.take(interface.joint_states, ros2::JointState::kType, first.cdr, first.received);
      waiting.pop_front();
      if (reading) newest = std::move(reading);
    }
    return newest;
  }

  std::optional<hand::HandReading> await(double timeout) {
    const auto start = Clock::now();
    std::optional<Clock::time_point> incomplete;
    while (seconds_since(start) < timeout || incomplete) {
      participant.wait(incomplete ? options.patience
                                  : std::max(0.0, timeout - seconds_since(start)));
      receive();
      const bool patient = !incomplete || seconds_since(*incomplete) < options.patience;
      if (auto reading = latest(patient)) return reading;
      if (waiting.empty()) {
        incomplete.reset();
      } else if (!incomplete) {
        incomplete = Clock::now();
      }
    }
    return std::nullopt;
  }

  /// s that a step waits: a tick where the hand fell silent before, so that it is stopped in time.
  double patience_of_step() const {
    return silent ? std::min(options.timeout, hand::kTick) : options.timeout;
  }

  /// The newest reading of those that still come. Of a hand that waits for commands one that comes
  /// unasked, taken for the answer to the first command, would put all answers one late.
  hand::HandReading settle(hand::HandReading reading) {
    const auto start = Clock::now();
    for (double left = kSettle; left > 0; left = kSettle - seconds_since(start)) {
      if (auto newer = await(left)) reading = std::move(*newer);
    }
    return reading;
  }

  std::optional<hand::HandReading> sense() {
    sensed = true;
    auto reading = standing();
    await_listeners();
    if (reading) last = settle(*std::move(reading));
    return last;
  }

  /// What is sent before the peers have found each other is lost: it is sent again.
  hand::HandReading first_step(const hand::HandCommand& command) {
    if (!sensed) sense();
    const auto start = Clock::now();
    stamp_next();
    send(command);
    auto reading = await(kSettle);
    while (!reading && seconds_since(start) < options.connect) {
      send_again(command);
      reading = await(kSettle);
    }
    if (!reading) throw no_hand();
    commanded = true;
    return keep(last ? *std::move(reading) : settle(*std::move(reading)), command);
  }

  hand::HandReading keep(hand::HandReading reading, const hand::HandCommand& command) {
    reading.mount = hand::nearest_mount(reading.mount.pose(), command.mount);
    last = std::move(reading);
    return *last;
  }
};

RemoteHand::RemoteHand(Participant& participant, const hand::Description& hand,
                       const ros2::RobotInterface& interface, const CommandTopics& topics,
                       const RemoteHandOptions& options)
    : impl_(new Impl(participant, hand, interface, topics, options)) {}

RemoteHand::~RemoteHand() = default;

hand::HandReading RemoteHand::step(const hand::HandCommand& command) {
  Impl& impl = *impl_;
  if (!impl.commanded) return impl.first_step(command);
  impl.stamp_next();
  impl.send(command);
  auto reading = impl.await(impl.patience_of_step());
  impl.silent = !reading;
  if (reading) return impl.keep(std::move(*reading), command);
  ++impl.repeats;
  impl.send_again(command);
  return *impl.last;
}

std::optional<hand::HandReading> RemoteHand::sense() { return impl_->sense(); }

const ros2::StreamCounts& RemoteHand::counts() const { return impl_->stream.counts(); }
std::uint64_t RemoteHand::messages() const {
  const Impl& impl = *impl_;
  return impl.received + impl.mount.written() +
         (impl.positions ? impl.positions->written() : impl.joints->written());
}
std::uint64_t RemoteHand::repeats() const { return impl_->repeats; }

}  // namespace palpate::bridge
