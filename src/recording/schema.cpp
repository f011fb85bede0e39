// SPDX-License-Identifier: Apache-2.0
#include "recording/schema.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/plausible.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::recording {
namespace {

using RowMajor4d = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

template <class Vector>
void store(const Vector& vector, double* values) {
  Eigen::Map<Vector>(values, vector.size()) = vector;
}

template <class Vector>
void load(const double* values, Vector& vector) {
  vector = Eigen::Map<const Vector>(values, vector.size());
}

void store_mount(const hand::MountPosition& mount, double* values) {
  store(mount.xyz, values);
  store(mount.ypr, values + 3);
}

void load_mount(const double* values, hand::MountPosition& mount) {
  load(values, mount.xyz);
  load(values + 3, mount.ypr);
}

void store_object(const Frame& frame, double* values) {
  if (frame.truth) {
    Eigen::Map<RowMajor4d>{values} = frame.truth->T_world_object.matrix();
  } else {
    std::fill_n(values, 16, std::numeric_limits<double>::quiet_NaN());
  }
}

void load_object(const double* values, Frame& frame) {
  if (std::isnan(values[0])) return;
  if (!frame.truth) frame.truth.emplace().joints.setZero(frame.reading.joints.size());
  std::array<double, 16> pose;
  std::copy_n(values, pose.size(), pose.begin());
  frame.truth->T_world_object = pose_from_row_major(pose);
}

void store_true_joints(const Frame& frame, double* values) {
  if (frame.truth) {
    store(frame.truth->joints, values);
  } else {
    std::fill_n(values, frame.reading.joints.size(), std::numeric_limits<double>::quiet_NaN());
  }
}

void load_true_joints(const double* values, Frame& frame) {
  if (frame.truth) load(values, frame.truth->joints);
}

using F = Frame;
using D = double;

constexpr int kPerJoint = -1, kPerActuator = -2;  // widths that depend on the hand

const std::array<FrameField, 9>& fixed_fields() {
  static const std::array<FrameField, 9> fields = {
      FrameField{"frames/time", 1, false, kMaxTime, [](const F& f, D* v) { *v = f.reading.time; },
                 [](const D* v, F& f) { f.reading.time = *v; }},
      FrameField{"frames/joints", kPerJoint, false, kMaxAngle,
                 [](const F& f, D* v) { store(f.reading.joints, v); },
                 [](const D* v, F& f) { load(v, f.reading.joints); }},
      FrameField{"frames/torques", kPerActuator, false, kMaxTorque,
                 [](const F& f, D* v) { store(f.reading.torques, v); },
                 [](const D* v, F& f) { load(v, f.reading.torques); }},
      FrameField{"frames/base_xyz_ypr", 6, false, kMaxAngle,
                 [](const F& f, D* v) { store_mount(f.reading.mount, v); },
                 [](const D* v, F& f) { load_mount(v, f.reading.mount); }},
      FrameField{"frames/base_force", 3, false, kMaxForce,
                 [](const F& f, D* v) { store(f.reading.mount_force, v); },
                 [](const D* v, F& f) { load(v, f.reading.mount_force); }},
      FrameField{"frames/command_positions", kPerActuator, false, kMaxAngle,
                 [](const F& f, D* v) { store(f.command.positions, v); },
                 [](const D* v, F& f) { load(v, f.command.positions); }},
      FrameField{"frames/command_base_xyz_ypr", 6, false, kMaxAngle,
                 [](const F& f, D* v) { store_mount(f.command.mount, v); },
                 [](const D* v, F& f) { load_mount(v, f.command.mount); }},
      FrameField{"frames/true_T_world_object", 16, true, kMaxLength, store_object, load_object},
      FrameField{"frames/true_joints", kPerJoint, true, kMaxAngle, store_true_joints,
                 load_true_joints},
  };
  return fields;
}

}  // namespace

std::vector<FrameField> frame_fields(const hand::Description& hand) {
  std::vector<FrameField> fields(fixed_fields().begin(), fixed_fields().end());
  for (FrameField& field : fields) {
    if (field.width == kPerJoint) field.width = hand.joint_count();
    if (field.width == kPerActuator) field.width = hand.actuator_count();
  }
  return fields;
}

Frame empty_frame(const hand::Description& hand) {
  Frame frame;
  frame.reading.joints.setZero(hand.joint_count());
  frame.reading.torques.setZero(hand.actuator_count());
  frame.reading.contacts.resize(hand.fingers.size());
  frame.command.positions.setZero(hand.actuator_count());
  return frame;
}

}  // namespace palpate::recording
