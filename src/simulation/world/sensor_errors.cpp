// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/sensor_errors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/se3.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::simulation {
namespace {

constexpr double kPresliding = 0.02;  // rad that a joint turns until its friction is overcome

std::size_t ticks_of(double seconds) {
  return static_cast<std::size_t>(std::lround(seconds / hand::kTick));
}

/// The value of `ticks` ago; the oldest where there is none so old.
template <class Value>
Value delayed(std::deque<Value>& last, Value now, std::size_t ticks) {
  last.push_back(std::move(now));
  if (last.size() > ticks + 1) last.pop_front();
  return last.front();
}

}  // namespace

SensorErrors::SensorErrors(const WorldOptions& options, const hand::Description& hand,
                           double weight, const RandomStream& random)
    : noise_(options.noise),
      touches_(hand.fingers.size()),
      touch_random_(random.fork("touch noise")),
      hand_(hand) {
  const WorldErrors& error = options.error;
  RandomStream arm = random.fork("arm"), load = random.fork("load bias"),
               drives = random.fork("drives");
  table_height_ = arm.uniform(-error.table_height, error.table_height);
  load_bias_ = error.load_bias / std::sqrt(3.0) * load.normal3();
  for (double& drift : load_drift_) drift = load.uniform(-error.load_drift, error.load_drift);
  load_weight_ = weight * load.uniform(-error.hand_weight, error.hand_weight);
  torque_scale_.resize(hand.actuator_count());
  torque_friction_.resize(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    torque_scale_[i] = 1 + drives.uniform(-error.torque, error.torque);
    torque_friction_[i] =
        error.torque_friction * hand.actuators[static_cast<std::size_t>(i)].max_torque;
  }
  RandomStream joints = random.fork("joint zeros"), tips = random.fork("fingertips");
  joint_zero_.resize(hand.joint_count());
  for (double& zero : joint_zero_) zero = error.joint_zero * joints.normal();
  drive_zero_ = hand::actuator_positions(hand, joint_zero_);
  for (TouchError& touch : touches_) {
    touch.radius = error.tip_radius * tips.normal();
    touch.offset = error.touch / std::sqrt(3.0) * tips.normal3();
  }
  reset();
}

void SensorErrors::reset() {
  drift_touch(0);
  slipped_.setZero(torque_scale_.size());
  last_positions_.resize(0);
  mounts_.clear();
  contacts_.clear();
}

hand::MountPosition SensorErrors::in_world(hand::MountPosition mount) const {
  mount.xyz.z() += table_height_;
  return mount;
}

hand::ActuatorVector SensorErrors::in_drives(const hand::ActuatorVector& positions) const {
  return positions - drive_zero_;
}

void SensorErrors::misread(hand::HandReading& reading) {
  const Eigen::Matrix3d R_world_mount = reading.mount.pose().linear();
  reading.mount_force += R_world_mount * (load_bias_ + reading.time * load_drift_);
  reading.mount_force.z() += load_weight_;
  reading.mount.xyz.z() -= table_height_;
  misread_torques(reading);
  reading.joints += joint_zero_;
  drift_touch(ticks_of(reading.time));
}

/// A first-order autoregressive process; it starts at its stationary distribution.
void SensorErrors::drift_touch(std::uint64_t tick) {
  if (noise_.touch_correlation == 0) return;
  const double kept = tick == 0 ? 0 : std::exp(-hand::kTick / noise_.touch_correlation);
  const double fresh = std::sqrt(1 - kept * kept);
  RandomStream random = touch_random_.fork("tick", tick);
  for (TouchError& touch : touches_) {
    touch.point = kept * touch.point + fresh * noise_.point * random.normal3();
    const double x = random.normal(), y = random.normal();
    touch.tilt = kept * touch.tilt + fresh * noise_.normal * Eigen::Vector2d(x, y);
  }
}

bool SensorErrors::misread(std::size_t finger, hand::TipContact& contact) const {
  const TouchError& touch = touches_[finger];
  contact.p += touch.offset + touch.point + touch.radius * contact.n;
  if (touch.tilt.isZero(0)) return true;
  contact.n = (contact.n + frame_with_z(contact.n).leftCols<2>() * touch.tilt).normalized();
  return contact.f.dot(contact.n) < 0;
}

SensorNoise SensorErrors::white_noise() const {
  SensorNoise noise = noise_;
  if (noise.touch_correlation > 0) noise.point = noise.normal = 0;
  return noise;
}

/// Friction that grows with the way since the joint turned back, as in Dahl's model.
void SensorErrors::misread_torques(hand::HandReading& reading) {
  if (torque_friction_.isZero() && torque_scale_.isOnes()) return;
  const hand::ActuatorVector positions = hand::actuator_positions(hand_, reading.joints);
  if (last_positions_.size() == 0) last_positions_ = positions;
  slipped_ += (positions - last_positions_) / kPresliding;
  slipped_ = slipped_.cwiseMax(-1).cwiseMin(1);
  last_positions_ = positions;
  reading.torques += torque_friction_.cwiseProduct(slipped_);
  reading.torques = reading.torques.cwiseProduct(torque_scale_);
}

void SensorErrors::delay(hand::HandReading& reading, RandomStream& random) {
  reading.mount = delayed(mounts_, reading.mount, ticks_of(noise_.mount_delay));
  reading.mount.xyz += noise_.mount * random.normal3();
  reading.mount.ypr += noise_.mount_angle * random.normal3();
  reading.contacts = delayed(contacts_, std::move(reading.contacts), ticks_of(noise_.touch_delay));
}

}  // namespace palpate::simulation
