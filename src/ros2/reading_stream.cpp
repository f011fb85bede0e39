// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/reading_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/plausible.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/ros2/cdr.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "palpate/tactile/sensors/intrinsic_contact.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::size_t kMaxFrames = 1000;  // that are remembered
constexpr int kMaxChain = 64;             // transforms from the mount to the world
constexpr auto kTickNs = static_cast<std::uint64_t>(1e9 * hand::kTick);
constexpr std::uint64_t kEarly = kTickNs / 4;  // by which clocks jitter

std::uint64_t time_of(const Header& header, std::uint64_t received) {
  const std::uint64_t stamped = nanoseconds_of(header.stamp);
  return stamped == 0 ? received : stamped;
}

template <class Named>
std::map<std::string, std::size_t, std::less<>> index_of(const std::vector<Named>& items) {
  std::map<std::string, std::size_t, std::less<>> index;
  for (std::size_t i = 0; i < items.size(); ++i) index[items[i].name] = i;
  return index;
}

/// @throws BadInput unless there is a value for each name
void check_sizes(const JointState& state, const std::vector<double>& values) {
  if (values.size() == state.name.size()) return;
  throw BadInput(fmt::format("{} values for {} joints", values.size(), state.name.size()));
}

/// The numbers of an array of 64 or 32 bits.
std::vector<double> values_of(std::string_view type, std::string_view cdr) {
  if (type == Float64MultiArray::kType) return deserialize<Float64MultiArray>(cdr).data;
  const auto narrow = deserialize<Float32MultiArray>(cdr).data;
  return {narrow.begin(), narrow.end()};
}

Eigen::Vector3d vector_in(const Vector3& v) { return {v.x, v.y, v.z}; }

}  // namespace

ReadingStream::ReadingStream(const hand::Description& hand, RobotInterface interface,
                             const StreamOptions& options)
    : hand_(hand),
      interface_(std::move(interface)),
      options_(options),
      joint_of_(index_of(hand.joints)),
      actuator_of_(index_of(hand.actuators)),
      tip_contacts_(hand.fingers.size()),
      joints_(hand.joints.size()) {
  torques_.setZero(hand.actuator_count());
  for (std::size_t i = 0; i < hand.fingers.size(); ++i) {
    finger_of_topic_[interface_.contacts_of(hand.fingers[i])] = i;
    finger_of_wrench_[interface_.fingertip_wrench_of(hand.fingers[i])] = i;
    finger_of_taxels_[interface_.taxels_of(hand.fingers[i])] = i;
  }
  for (const auto& [name, cells] : interface_.taxel_layout) {
    if (std::ranges::any_of(hand.fingers, [&](const auto& finger) { return finger.name == name; }))
      continue;
    throw BadInput(
        fmt::format("taxels of a finger {:?}, which the hand {} has not", name, hand.name));
  }
}

std::optional<hand::HandReading> ReadingStream::take(std::string_view topic, std::string_view type,
                                                     std::string_view cdr, std::uint64_t received) {
  try {
    if (type == JointState::kType && topic == interface_.joint_states) {
      return take_joints(deserialize<JointState>(cdr), received);
    }
    if (type == JointState::kType && topic == interface_.actuator_states) {
      take_actuators(deserialize<JointState>(cdr), received);
    } else if (type == TFMessage::kType &&
               (topic == interface_.tf || topic == interface_.tf_static)) {
      take_transforms(deserialize<TFMessage>(cdr), topic == interface_.tf_static, received);
    } else if (type == WrenchStamped::kType && topic == interface_.wrench) {
      take_wrench(deserialize<WrenchStamped>(cdr), received);
    } else if (type == WrenchStamped::kType) {
      const auto finger = finger_of_wrench_.find(topic);
      if (finger == finger_of_wrench_.end()) return std::nullopt;
      take_fingertip_wrench(finger->second, deserialize<WrenchStamped>(cdr), received);
    } else if (type == PointCloud2::kType) {
      const auto finger = finger_of_topic_.find(topic);
      if (finger == finger_of_topic_.end()) return std::nullopt;
      take_contacts(finger->second, deserialize<PointCloud2>(cdr), received);
    } else if (type == Float64MultiArray::kType || type == Float32MultiArray::kType) {
      const auto finger = finger_of_taxels_.find(topic);
      if (finger == finger_of_taxels_.end()) return std::nullopt;
      take_taxels(finger->second, values_of(type, cdr), received);
    }
  } catch (const BadInput& error) {
    drop(topic, error);
  }
  return std::nullopt;
}

void ReadingStream::drop(std::string_view topic, const BadInput& error) {
  ++counts_.malformed;
  counts_.last_error = fmt::format("{}: {}", topic, error.what());
}

bool ReadingStream::is_later(std::uint64_t time, LatestTime& latest) {
  if (latest.take(time) != TimeOrder::late) return true;
  ++counts_.out_of_order;
  return false;
}

bool ReadingStream::is_fresh(std::uint64_t then, std::uint64_t now) const {
  const auto age = static_cast<double>(now) - static_cast<double>(then);
  return then != 0 && std::abs(age) <= 1e9 * options_.max_age;
}

/// Of the hand's joints alone: what others of the robot report is nobody's business here.
TimeOrder ReadingStream::update_joints(const JointState& state, std::uint64_t time) {
  auto order = TimeOrder::late;
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const auto known = joint_of_.find(state.name[i]);
    if (known == joint_of_.end()) continue;
    SensedJoint& joint = joints_[known->second];
    const TimeOrder own = joint.time.take(time);
    if (own == TimeOrder::late) continue;
    if (order != TimeOrder::set_back) order = own;
    joint.angle = state.position[i];
  }
  return order;
}

/// Contacts, transforms and wrench of before are not fresh any more, and need not be forgotten.
void ReadingStream::restart() {
  ++counts_.restarts;
  start_.reset();
  joints_at_ = next_ = 0;
}

std::optional<hand::HandReading> ReadingStream::take_joints(const JointState& state,
                                                            std::uint64_t received) {
  check_sizes(state, state.position);
  bool any = false;
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    if (!joint_of_.contains(state.name[i])) continue;
    any = true;
    plausible(state.position[i], -kMaxAngle, kMaxAngle, "a joint's position");
  }
  if (!any) return std::nullopt;  // of another part of the robot
  const std::uint64_t time = time_of(state.header, received);
  const TimeOrder order = update_joints(state, time);
  if (order == TimeOrder::late) {
    ++counts_.out_of_order;
    return std::nullopt;
  }
  if (order == TimeOrder::set_back) restart();
  ++counts_.joint_states;
  counts_.gaps += joints_at_ != 0 && !is_fresh(joints_at_, time) ? 1 : 0;
  joints_at_ = std::max(joints_at_, time);
  return reading_at(time);
}

void ReadingStream::take_actuators(const JointState& state, std::uint64_t received) {
  check_sizes(state, state.effort);
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    if (!actuator_of_.contains(state.name[i])) continue;
    plausible(state.effort[i], -kMaxTorque, kMaxTorque, "a torque");
  }
  if (!is_later(time_of(state.header, received), torques_at_)) return;
  ++counts_.actuator_states;
  for (std::size_t i = 0; i < state.name.size(); ++i) {
    const auto actuator = actuator_of_.find(state.name[i]);
    if (actuator == actuator_of_.end()) continue;
    torques_[static_cast<Eigen::Index>(actuator->second)] = state.effort[i];
  }
}

void ReadingStream::take_contacts(std::size_t finger, const PointCloud2& cloud,
                                  std::uint64_t received) {
  const std::string& frame = tip_frame(hand_, hand_.fingers[finger]);
  if (cloud.header.frame_id != frame) {
    throw BadInput(
        fmt::format("contacts in the frame {:?}, not {:?}", cloud.header.frame_id, frame));
  }
  auto contacts = ros2::contacts_of(cloud);
  for (const hand::TipContact& contact : contacts) {
    const double off = hand::distance_from_tip(contact.p, hand_.fingers[finger]);
    plausible(off, 0, hand::kTipReach, "the distance of a contact from its fingertip");
  }
  TipContacts& sensed = tip_contacts_[finger];
  if (!is_later(time_of(cloud.header, received), sensed.time)) return;
  ++counts_.contacts;
  sensed.contacts = std::move(contacts);
}

/// The one contact that explains the wrench, if any does; the sensor's frame is the distal link's.
void ReadingStream::take_fingertip_wrench(std::size_t finger, const WrenchStamped& wrench,
                                          std::uint64_t received) {
  const std::string& frame = tip_frame(hand_, hand_.fingers[finger]);
  if (wrench.header.frame_id != frame) {
    throw BadInput(fmt::format("a fingertip's wrench in the frame {:?}, not {:?}",
                               wrench.header.frame_id, frame));
  }
  const Eigen::Vector3d force = vector_in(wrench.wrench.force);
  const Eigen::Vector3d moment = vector_in(wrench.wrench.torque);
  check_plausible(force, kMaxForce, "a force on a fingertip");
  check_plausible(moment, kMaxTorque, "a moment on a fingertip");
  TipContacts& sensed = tip_contacts_[finger];
  if (!is_later(time_of(wrench.header, received), sensed.time)) return;
  ++counts_.contacts;
  sensed.contacts.clear();
  const hand::TipCapsule& tip = hand_.fingers[finger].tip;
  const auto contact = tactile::contact_of_wrench({force, moment}, {tip.a, tip.b, tip.radius},
                                                  Eigen::Isometry3d::Identity());
  if (contact) sensed.contacts.push_back(tactile::tip_contact(*contact));
}

/// An array has no stamp and is of the latest joint state, so that clocks need not agree.
void ReadingStream::take_taxels(std::size_t finger, std::span<const double> values,
                                std::uint64_t received) {
  const auto cells = interface_.taxel_layout.find(hand_.fingers[finger].name);
  if (cells == interface_.taxel_layout.end()) return;
  const auto contacts = tactile::contacts_of_values(cells->second, values);
  TipContacts& sensed = tip_contacts_[finger];
  ++counts_.contacts;
  sensed.time.set(joints_at_ != 0 ? joints_at_ : received);
  sensed.contacts.clear();
  for (const auto& contact : contacts) sensed.contacts.push_back(tactile::tip_contact(contact));
}

void ReadingStream::take_wrench(const WrenchStamped& wrench, std::uint64_t received) {
  const Eigen::Vector3d force = vector_in(wrench.wrench.force);
  check_plausible(force, kMaxForce, "a force of the mount");
  const bool in_world = wrench.header.frame_id == interface_.world;
  if (!in_world && wrench.header.frame_id != interface_.mount) {
    throw BadInput(fmt::format("a wrench in the frame {:?}, neither {:?} nor {:?}",
                               wrench.header.frame_id, interface_.world, interface_.mount));
  }
  const std::uint64_t time = time_of(wrench.header, received);
  const auto T_world_mount = in_world ? Eigen::Isometry3d::Identity() : mount_at(time);
  if (!T_world_mount || !is_later(time, force_at_)) return;
  ++counts_.wrenches;
  force_ = T_world_mount->linear() * force;
}

/// What is wrong with one transform of a message says nothing of the others.
void ReadingStream::take_transforms(const TFMessage& message, bool fixed, std::uint64_t received) {
  for (const TransformStamped& transform : message.transforms) {
    try {
      take_transform(transform, fixed, received);
    } catch (const BadInput& error) {
      drop(fixed ? interface_.tf_static : interface_.tf, error);
    }
  }
}

void ReadingStream::take_transform(const TransformStamped& transform, bool fixed,
                                   std::uint64_t received) {
  const Eigen::Isometry3d T = transform_of(transform.transform);
  auto known = transforms_.find(transform.child_frame_id);
  if (known == transforms_.end()) {
    if (transforms_.size() >= kMaxFrames) return;
    known = transforms_.emplace(transform.child_frame_id, Transformed{}).first;
  }
  if (!is_later(time_of(transform.header, received), known->second.time)) return;
  ++counts_.transforms;
  known->second.parent = transform.header.frame_id;
  known->second.T = T;
  known->second.fixed = fixed;
}

bool ReadingStream::has_all_since(std::uint64_t time) const {
  const auto mount = transforms_.find(interface_.mount);
  return torques_at_.time() >= time && force_at_.time() >= time && mount != transforms_.end() &&
         mount->second.time.time() >= time &&
         std::all_of(tip_contacts_.begin(), tip_contacts_.end(),
                     [&](const TipContacts& sensed) { return sensed.time.time() >= time; });
}

std::optional<Eigen::Isometry3d> ReadingStream::mount_at(std::uint64_t time) const {
  Eigen::Isometry3d T_frame_mount = Eigen::Isometry3d::Identity();
  std::string_view frame = interface_.mount;
  for (int i = 0; i < kMaxChain; ++i) {
    if (frame == interface_.world) return T_frame_mount;
    const auto known = transforms_.find(frame);
    if (known == transforms_.end()) return std::nullopt;
    if (!known->second.fixed && !is_fresh(known->second.time.time(), time)) return std::nullopt;
    T_frame_mount = known->second.T * T_frame_mount;
    frame = known->second.parent;
  }
  return std::nullopt;
}

std::optional<hand::HandReading> ReadingStream::reading_at(std::uint64_t time) {
  if (time + kEarly < next_) return std::nullopt;
  const auto T_world_mount = mount_at(time);
  hand::HandReading reading;
  reading.joints.setZero(hand_.joint_count());
  bool complete = T_world_mount.has_value();
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    complete = complete && is_fresh(joints_[i].time.time(), time);
    reading.joints[static_cast<Eigen::Index>(i)] = joints_[i].angle;
  }
  if (!complete) {
    ++counts_.incomplete;
    return std::nullopt;
  }
  if (!start_) start_ = time;
  next_ = next_ + kTickNs > time ? next_ + kTickNs : time + kTickNs;
  reading.time = 1e-9 * static_cast<double>(time - *start_);
  reading.torques = torques_;
  reading.mount = hand::MountPosition::at(*T_world_mount);
  if (is_fresh(force_at_.time(), time)) reading.mount_force = force_;
  for (const TipContacts& sensed : tip_contacts_) {
    reading.contacts.push_back(
        is_fresh(sensed.time.time(), time) ? sensed.contacts : std::vector<hand::TipContact>{});
  }
  ++counts_.readings;
  return reading;
}

}  // namespace palpate::ros2
