// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/export_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>

#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/mesh.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/recording/estimate_record.hpp"
#include "palpate/ros2/mcap_writer.hpp"
#include "palpate/ros2/robot_messages.hpp"

namespace palpate::ros2 {
namespace {

bool is_same(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b) {
  constexpr double kSame = 1e-6;  // m
  return a.triangles == b.triangles &&
         std::ranges::equal(a.vertices, b.vertices,
                            [](const auto& p, const auto& q) { return (p - q).norm() < kSame; });
}

/// The name of an object that has no file. A file may have the name of another object.
std::string name_without_file(const geometry::KnownObject& object) {
  const bool built_in = std::ranges::count(geometry::built_in_objects(), object.name) > 0 ||
                        object.name == "bunny" || object.name.starts_with("generated:");
  if (!built_in) return "";  // and opens no file that a recording names
  try {
    return is_same(geometry::load_known_object(object.name).mesh, object.mesh) ? object.name : "";
  } catch (const BadInput&) {
    return "";
  }
}

class Exporter {
 public:
  Exporter(const recording::Recording& recording, McapWriter& writer,
           const RobotInterface& interface)
      : recording_(recording), writer_(writer), interface_(interface) {}

  /// Everything in the order of time, which is that of the frames.
  void write() {
    for (const auto& frame : recording_.frames) {
      write_events_until(frame.reading.time);
      write_frame(frame.reading);
    }
    write_events_until(std::numeric_limits<double>::infinity());
  }

  void write_header() {
    const auto& header = recording_.header;
    writer_.metadata(kMetadata, {{"object", name_without_file(header.object)},
                                 {"hand", header.hand.name},
                                 {"seed", std::to_string(header.seed)},
                                 {"program_version", header.program_version},
                                 {"config_toml", header.config_toml}});
    const double start = recording_.frames.empty() ? 0 : recording_.frames.front().reading.time;
    writer_.write(topic("object"), nanoseconds_of(start), object_marker(header.object.mesh));
  }

 private:
  [[nodiscard]] std::string topic(const char* name) const {
    return interface_.palpate + "/" + name;
  }

  void write_frame(const hand::HandReading& reading) {
    const std::uint64_t time = nanoseconds_of(reading.time);
    const auto& hand = recording_.header.hand;
    const ReadingMessages messages = messages_of(reading, hand, interface_, time);
    // Joint states last: a reading is made of them and of what came before.
    writer_.write(interface_.tf, time, messages.tf);
    for (std::size_t i = 0; i < messages.contacts.size(); ++i) {
      writer_.write(interface_.contacts_of(hand.fingers[i]), time, messages.contacts[i]);
    }
    writer_.write(interface_.wrench, time, messages.wrench);
    writer_.write(interface_.actuator_states, time, messages.actuators);
    writer_.write(interface_.joint_states, time, messages.joints);
  }

  /// Events and estimates of before a time, s.
  void write_events_until(double time) {
    const auto& events = recording_.events;
    for (; event_ < events.size() && events[event_].time < time; ++event_) {
      const auto& event = events[event_];
      writer_.write(topic("events"), nanoseconds_of(event.time),
                    String{fmt::format("{} {}: {}", recording::to_string(event.kind), event.phase,
                                       event.text)});
    }
    const auto& estimates = recording_.estimates;
    for (; estimate_ < estimates.size() && estimates[estimate_].time < time; ++estimate_) {
      write_estimate(estimates[estimate_]);
    }
  }

  void write_estimate(const recording::EstimateRecord& estimate) {
    const std::uint64_t time = nanoseconds_of(estimate.time);
    auto messages = messages_of(recording::posterior_of(estimate), estimate.contacts,
                                geometry::bounds(recording_.header.object.mesh), interface_, time);
    for (const auto& pose : messages.pose) writer_.write(topic("estimate"), time, pose);
    writer_.write(topic("modes"), time, messages.modes);
    writer_.write(topic("mode_weights"), time, messages.weights);
    writer_.write(topic("status"), time, messages.status);
    writer_.write(topic("markers"), time, messages.markers);
    if (!messages.tf.transforms.empty()) writer_.write(interface_.tf, time, messages.tf);
  }

  const recording::Recording& recording_;
  McapWriter& writer_;
  const RobotInterface& interface_;
  std::size_t event_ = 0, estimate_ = 0;
};

}  // namespace

std::uint64_t export_mcap(const recording::Recording& recording, const std::filesystem::path& path,
                          const RobotInterface& interface, std::size_t chunk_size) {
  McapWriter writer(path, chunk_size);
  Exporter exporter(recording, writer, interface);
  exporter.write_header();
  exporter.write();
  writer.finish();
  return writer.messages();
}

}  // namespace palpate::ros2
