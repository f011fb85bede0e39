// SPDX-License-Identifier: Apache-2.0
#include "palpate/bridge/estimator_node.hpp"

#include <fmt/format.h>

#include <chrono>
#include <deque>
#include <exception>
#include <future>
#include <optional>
#include <utility>

#include "bridge/stream_readers.hpp"
#include "bridge/wall_clock.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/mesh.hpp"
#include "palpate/ros2/cdr.hpp"

namespace palpate::bridge {
namespace {

constexpr double kResultPoll = 0.02;  // s after which a finished estimate is looked for
constexpr std::uint64_t kSecond = 1'000'000'000;

using Task = estimation::HeldPoseFollower::Task;

/// An estimate that another thread makes.
struct Pending {
  Task task;
  std::uint64_t time = 0;  ///< ns, of its last reading
  std::future<estimation::HeldPoseEstimate> result;
};

/// @throws BadInput unless it is known where the hand's parts are
const hand::Description& with_links(const hand::Description& hand) {
  if (!hand.links.empty()) return hand;
  throw BadInput(fmt::format("the hand {:?} has no links", hand.name));
}

ros2::DiagnosticStatus diagnosis(const ros2::StreamCounts& counts, std::uint64_t readings_before,
                                 const NodeReport& report, std::string_view hand,
                                 const std::string& refused) {
  ros2::DiagnosticStatus status;
  const bool silent = counts.readings == readings_before;
  const bool faulty = counts.malformed + counts.out_of_order + counts.gaps + counts.incomplete +
                              counts.restarts + report.failed >
                          0 ||
                      !refused.empty();
  status.level = silent   ? ros2::DiagnosticStatus::kStale
                 : faulty ? ros2::DiagnosticStatus::kWarn
                          : ros2::DiagnosticStatus::kOk;
  status.name = "palpate: readings";
  status.hardware_id = hand;
  status.message = silent ? "no readings" : counts.last_error;
  if (report.failed > 0 && status.message.empty()) status.message = report.last_failure;
  if (!refused.empty()) status.message = "senders that are best effort: " + refused;
  const auto add = [&](const char* key, std::uint64_t value) {
    status.values.push_back({key, std::to_string(value)});
  };
  add("readings", counts.readings);
  add("joint_states", counts.joint_states);
  add("malformed", counts.malformed);
  add("out_of_order", counts.out_of_order);
  add("gaps", counts.gaps);
  add("incomplete", counts.incomplete);
  add("restarts", counts.restarts);
  add("failed_estimates", report.failed);
  return status;
}

}  // namespace

struct EstimatorNode::Impl {
  Participant& participant;
  const hand::Description& hand;
  ros2::RobotInterface interface;
  Eigen::AlignedBox3d bounds;
  ros2::ReadingStream stream;
  estimation::HeldPoseFollower follower;
  std::deque<RawReader> readers;
  RawReader commands;
  TopicWriter<ros2::PoseWithCovarianceStamped> pose;
  TopicWriter<ros2::PoseArray> modes;
  TopicWriter<ros2::Float64MultiArray> weights;
  TopicWriter<ros2::String> status;
  TopicWriter<ros2::MarkerArray> markers, mesh;
  TopicWriter<ros2::TFMessage> tf;
  TopicWriter<ros2::DiagnosticArray> diagnostics;
  std::optional<Pending> pending;
  NodeReport report;
  bool running = true;
  std::uint64_t diagnosed_at = 0, readings_before = 0;

  Impl(Participant& at, const geometry::ObjectModel& object, const hand::Description& described,
       const ros2::RobotInterface& named, const estimation::HeldPoseOptions& options,
       std::uint64_t seed)
      : participant(at),
        hand(with_links(described)),
        interface(named),
        bounds(geometry::bounds(object.object().mesh)),
        stream(described, named),
        follower(object, described, options, seed),
        commands(at, named.palpate + "/command", ros2::String::kType, {}),
        pose(at, named.palpate + "/estimate"),
        modes(at, named.palpate + "/modes"),
        weights(at, named.palpate + "/mode_weights"),
        status(at, named.palpate + "/status"),
        markers(at, named.palpate + "/markers"),
        mesh(at, named.palpate + "/object", {.reliable = true, .latched = true, .depth = 1}),
        tf(at, named.tf, sensor_qos()),
        diagnostics(at, "/diagnostics") {
    add_stream_readers(participant, hand, interface, readers);
    mesh.write(ros2::object_marker(object.object().mesh));
  }

  void obey(std::string_view cdr) {
    std::string command;
    try {
      command = ros2::deserialize<ros2::String>(cdr).data;
    } catch (const BadInput&) {
    }
    report.commands += command == "start" || command == "stop" || command == "estimate" ? 1 : 0;
    if (command == "start") running = true;
    if (command == "stop") running = false;
    if (command == "stop" || command == "estimate") follower.forget();
  }

  void receive() {
    commands.take([this](std::string_view cdr, std::uint64_t) {
      ++report.messages;
      obey(cdr);
    });
    for (RawReader& reader : readers) {
      reader.take([&](std::string_view cdr, std::uint64_t now) {
        ++report.messages;
        const auto reading = stream.take(reader.topic(), reader.type(), cdr, now);
        if (reading && running) guarded([&] { update(*reading); });
      });
    }
  }

  /// Readings that no estimate can be made of are counted, and do not end the node.
  template <class Work>
  void guarded(const Work& work) {
    try {
      work();
    } catch (const std::exception& error) {
      ++report.failed;
      report.last_failure = error.what();
    }
  }

  std::uint64_t time_of(const hand::HandReading& reading) const {
    return *stream.start() + ros2::nanoseconds_of(reading.time);
  }

  void update(const hand::HandReading& reading) {
    follower.update(reading);
    const auto messages =
        ros2::messages_of(follower.posterior(), {}, bounds, interface, time_of(reading));
    for (const auto& message : messages.pose) report.poses += pose.write(message) ? 1 : 0;
    if (!messages.tf.transforms.empty()) tf.write(messages.tf);
    if (pending || !follower.due()) return;
    Task task = follower.task();
    pending.emplace(task, time_of(reading), std::future<estimation::HeldPoseEstimate>());
    pending->result = std::async(
        std::launch::async, [this, task = std::move(task)] { return follower.estimate(task); });
  }

  void finish_estimate() {
    using namespace std::chrono_literals;
    if (!pending || pending->result.wait_for(0s) != std::future_status::ready) return;
    Pending done = std::move(*pending);
    pending.reset();
    guarded([&] { publish(std::move(done)); });
  }

  void publish(Pending done) {
    estimation::HeldPoseEstimate estimate = done.result.get();
    const auto messages =
        ros2::messages_of(estimate.posterior, estimate.contacts, bounds, interface, done.time);
    follower.accept(done.task, std::move(estimate));
    modes.write(messages.modes);
    weights.write(messages.weights);
    status.write(messages.status);
    markers.write(messages.markers);
    ++report.estimates;
  }

  /// Once a second. @return whether it is time to
  bool diagnose() {
    const std::uint64_t now = wall_clock();
    if (now < diagnosed_at + kSecond) return false;
    diagnosed_at = now;
    diagnostics.write({{ros2::stamp_of(now), ""},
                       {diagnosis(stream.counts(), readings_before, report, hand.name,
                                  refused_topics(readers))}});
    readings_before = stream.counts().readings;
    return true;
  }
};

EstimatorNode::EstimatorNode(Participant& participant, const geometry::ObjectModel& object,
                             const hand::Description& hand, const ros2::RobotInterface& interface,
                             const estimation::HeldPoseOptions& options, std::uint64_t seed)
    : impl_(new Impl(participant, object, hand, interface, options, seed)) {}

EstimatorNode::~EstimatorNode() = default;

void EstimatorNode::run(const std::stop_token& stop, const Observer& observer) {
  while (!stop.stop_requested()) {
    impl_->participant.wait(kResultPoll);
    impl_->receive();
    impl_->finish_estimate();
    if (impl_->diagnose() && observer) observer(report());
  }
}

NodeReport EstimatorNode::report() const {
  NodeReport report = impl_->report;
  report.received = impl_->stream.counts();
  for (const RawReader& reader : impl_->readers) report.lost += reader.lost();
  report.refused = refused_topics(impl_->readers);
  report.messages += impl_->pose.written() + impl_->modes.written() + impl_->weights.written() +
                     impl_->status.written() + impl_->markers.written() + impl_->mesh.written() +
                     impl_->tf.written() + impl_->diagnostics.written();
  return report;
}

}  // namespace palpate::bridge
