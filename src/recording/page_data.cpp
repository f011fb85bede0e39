// SPDX-License-Identifier: Apache-2.0
#include "recording/page_data.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/hand/kinematics.hpp"
#include "recording/base64.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxFrames = 1500, kMinStride = 2;  // of recorded frames, 100 a second

constexpr std::size_t kMaxTouchFrames = 1500;  // beside those

/// Recorded frames that the page holds: every so-manieth, those of touches between, and the last.
std::vector<std::size_t> chosen_frames(const std::vector<Frame>& frames) {
  const std::size_t count = frames.size();
  const std::size_t stride = std::max(kMinStride, (count + kMaxFrames - 1) / kMaxFrames);
  std::vector<std::size_t> chosen;
  std::size_t beside = 0;
  TouchesShown touches;
  for (std::size_t i = 0; i < count; ++i) {
    const bool regular = i % stride == 0 || i + 1 == count;
    if (regular) touches.begin();
    const bool another = touches.add(frames[i].reading) && !regular && beside < kMaxTouchFrames;
    beside += another ? 1 : 0;
    if (regular || another) chosen.push_back(i);
  }
  return chosen;
}

void append(const Eigen::Vector3d& v, std::vector<float>& values) {
  for (const double x : v) values.push_back(static_cast<float>(x));
}

void append_pose(const Eigen::Isometry3d& T, std::vector<float>& values) {
  append(T.translation(), values);
  const Eigen::Quaterniond q(T.linear());
  for (const double x : q.coeffs()) values.push_back(static_cast<float>(x));
}

/// Series of the page, frame after frame.
struct Series {
  std::vector<float> time, links, object, contacts;  // a contact: p, n in the world, force along n
  std::vector<std::uint32_t> contact_counts;
  std::vector<std::uint8_t> has_object, fingers;
};

void append_contacts(const hand::HandReading& reading, const hand::Description& hand,
                     const std::vector<Eigen::Isometry3d>& T_world_links, Series& series) {
  std::uint32_t count = 0;
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    if (reading.contacts[finger].empty()) continue;  // a hand may be described without links
    const auto& T = T_world_links[static_cast<std::size_t>(hand.fingers[finger].link)];
    for (const auto& contact : reading.contacts[finger]) {
      append(T * contact.p, series.contacts);
      append(T.linear() * contact.n, series.contacts);
      series.contacts.push_back(static_cast<float>(-contact.f.dot(contact.n)));
      series.fingers.push_back(static_cast<std::uint8_t>(finger));
      ++count;
    }
  }
  series.contact_counts.push_back(count);
}

void append_frame(const Frame& frame, const hand::Description& hand, double origin,
                  Series& series) {
  series.time.push_back(static_cast<float>(frame.reading.time - origin));
  auto T_world_links = hand::forward_kinematics(hand, frame.reading.joints);
  const Eigen::Isometry3d T_world_mount = frame.reading.mount.pose();
  for (auto& T : T_world_links) {
    T = T_world_mount * T;
    append_pose(T, series.links);
  }
  append_pose(frame.truth ? frame.truth->T_world_object : Eigen::Isometry3d::Identity(),
              series.object);
  series.has_object.push_back(frame.truth.has_value());
  append_contacts(frame.reading, hand, T_world_links, series);
}

json series_to_json(const Series& series) {
  return {{"count", series.time.size()},
          {"time", base64<float>(series.time)},
          {"link_poses", base64<float>(series.links)},
          {"object_poses", base64<float>(series.object)},
          {"has_object", base64<std::uint8_t>(series.has_object)},
          {"contact_counts", base64<std::uint32_t>(series.contact_counts)},
          {"contacts", base64<float>(series.contacts)},
          {"contact_fingers", base64<std::uint8_t>(series.fingers)}};
}

json fingers_to_json(const hand::Description& hand) {
  json names = json::array();
  for (const auto& finger : hand.fingers) names.push_back(finger.name);
  return names;
}

json chosen_to_json(const Recording& recording) {
  Series series;
  const double origin = page_origin(recording);
  for (const std::size_t i : chosen_frames(recording.frames)) {
    append_frame(recording.frames[i], recording.header.hand, origin, series);
  }
  return series_to_json(series);
}

}  // namespace

double page_origin(double first_frame) { return std::floor(first_frame); }

double page_origin(const Recording& recording) {
  return recording.frames.empty() ? 0 : page_origin(recording.frames.front().reading.time);
}

bool TouchesShown::add(const hand::HandReading& reading) {
  const std::uint32_t before = seen_;
  for (std::size_t finger = 0; finger < reading.contacts.size(); ++finger) {
    if (!reading.contacts[finger].empty()) seen_ |= std::uint32_t{1} << finger;
  }
  return seen_ != before;
}

json frame_to_json(const Frame& frame, const hand::Description& hand, double origin) {
  Series series;
  append_frame(frame, hand, origin, series);
  return series_to_json(series);
}

json page_data(const Recording& recording, const hand::HandVisuals& visuals) {
  const RecordingHeader& header = recording.header;
  json data = {{"program_version", header.program_version},
               {"seed", std::to_string(header.seed)},
               {"finished", recording.finished},
               {"object", header.object.name},
               {"mass", header.object.mass},
               {"symmetries", header.object.symmetries.size()},
               {"recorded_frames", recording.frames.size()},
               {"links", header.hand.links.size()},
               {"palm", std::max(header.hand.palm, 0)},
               {"fingers", fingers_to_json(header.hand)},
               {"frames", chosen_to_json(recording)}};
  data.update(page_shapes(recording, visuals));
  data.update(page_story(recording));
  return data;
}

}  // namespace palpate::recording
