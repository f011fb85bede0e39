// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/simulated_hand.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <string>

#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "simulation/contact/fingertip_touch.hpp"
#include "simulation/world/object_step.hpp"

namespace palpate::simulation {
namespace {

using Index = std::size_t;

constexpr double kHeavy = 4;                     // kg; the Shadow hand has 3.8
constexpr double kHeavyLever = 0.9;              // kg m from the mount; the Shadow hand has 0.75
constexpr double kGentle = 3, kGentleTurn = 10;  // m/s^2, rad/s^2
constexpr double kTorqueLever = 0.025;  // m: noise of the torques over that of the mount's load

Vector6d mount_vector(const hand::MountPosition& mount) {
  Vector6d result;
  result << mount.xyz, mount.ypr;
  return result;
}

/// Weight of the hand, N.
double weight_of_hand(const Scene& scene) {
  return scene.model->body_subtreemass[scene.root] * vector3(scene.model->opt.gravity).norm();
}

/// A heavy hand is accelerated as gently as an arm would, or its inertia would load the mount as a
/// collision does.
hand::MountLimits floating_limits(const Scene& scene, const mjData& data,
                                  const Eigen::Vector3d& mount) {
  const double lever = (vector3(data.subtree_com + 3 * scene.root) - mount).norm();
  const double mass = scene.model->body_subtreemass[scene.root];
  if (mass <= kHeavy && mass * lever <= kHeavyLever) return {};
  return {.acceleration = kGentle, .turn_acceleration = kGentleTurn};
}

}  // namespace

SimulatedHand::SimulatedHand(const Scene& scene, mjData& data, const hand::Description& hand,
                             const WorldOptions& options, const RandomStream& random)
    : scene_(scene),
      data_(data),
      hand_(hand),
      noise_(options.noise),
      errors_(options, hand, weight_of_hand(scene), random),
      integral_(options.integral),
      random_(random),
      steps_a_tick_(static_cast<int>(std::lround(hand::kTick / scene.model->opt.timestep))) {
  stiffness_.resize(static_cast<Eigen::Index>(scene.actuators.size()));
  for (Index i = 0; i < scene.actuators.size(); ++i) {
    stiffness_[static_cast<int>(i)] = scene.model->actuator_gainprm[mjNGAIN * scene.actuators[i]];
  }
}

void SimulatedHand::apply(const hand::HandCommand& command) {
  const Vector6d mount = mount_vector(errors_.in_world(command.mount));
  if (command.positions.size() != stiffness_.size()) {
    throw BadInput(fmt::format("{} actuators are commanded, the hand has {}",
                               command.positions.size(), stiffness_.size()));
  }
  if (!command.positions.allFinite() || !mount.allFinite()) {
    throw BadInput(
        fmt::format("the hand's command has a value that is not finite: mount {}, sum of "
                    "positions {}",
                    fmt::join(mount, " "), command.positions.sum()));
  }
  const hand::ActuatorVector positions = errors_.in_drives(command.positions);
  for (Index i = 0; i < scene_.actuators.size(); ++i) {
    data_.ctrl[scene_.actuators[i]] = positions[static_cast<int>(i)];
  }
  carry_to(errors_.in_world(command.mount));
}

void SimulatedHand::carry_to(const hand::MountPosition& mount) {
  commanded_ = mount;
  const auto command = [&](const auto& positions) {
    for (Index i = 0; i < scene_.base_actuators.size(); ++i) {
      data_.ctrl[scene_.base_actuators[i]] = positions[static_cast<int>(i)];
    }
  };
  if (follower_) {
    command(follower_->follow(mount.pose()));
  } else {
    command(mount_vector(mount));
  }
}

hand::MountLimits SimulatedHand::mount_limits() const {
  return follower_ ? follower_->arm().limits : limits_;
}

hand::ArmPosture SimulatedHand::arm_posture() const {
  return follower_ ? follower_->posture() : hand::ArmPosture{};
}

hand::PathFeasibility SimulatedHand::check_path(std::span<const hand::MountPosition> way) const {
  if (!follower_) return {};
  std::vector<hand::MountPosition> in_world;
  in_world.reserve(way.size());
  for (const hand::MountPosition& mount : way) in_world.push_back(errors_.in_world(mount));
  return follower_->check_path(in_world);
}

/// The servos give P and D; the integral moves their setpoint by what makes up its torque.
void SimulatedHand::integrate(const hand::HandCommand& command) {
  const hand::ActuatorVector positions = errors_.in_drives(command.positions);
  hand::ActuatorVector errors(stiffness_.size());
  for (Index i = 0; i < scene_.actuators.size(); ++i) {
    const auto k = static_cast<int>(i);
    errors[k] = positions[k] - data_.actuator_length[scene_.actuators[i]];
  }
  const hand::ActuatorVector& torques =
      integral_.update(errors, stiffness_, scene_.model->opt.timestep);
  for (Index i = 0; i < scene_.actuators.size(); ++i) {
    const auto k = static_cast<int>(i);
    data_.ctrl[scene_.actuators[i]] = positions[k] + torques[k] / stiffness_[k];
  }
}

void SimulatedHand::push_object(const Eigen::Vector3d& velocity, double seconds) {
  push_ = velocity;
  pushed_steps_ = static_cast<int>(std::lround(seconds / scene_.model->opt.timestep));
}

void SimulatedHand::step_physics() {
  if (pushed_steps_ > 0) {
    --pushed_steps_;
    const int joint = scene_.model->body_jntadr[scene_.object];
    Eigen::Vector3d::Map(data_.qvel + scene_.model->jnt_dofadr[joint]) = push_;
  }
  if (!observer_) {
    mj_step(scene_.model.get(), &data_);
    return;
  }
  const StepStart start = read_step_start(scene_, data_);
  mj_step(scene_.model.get(), &data_);
  observer_(read_object_step(scene_, data_, start));
}

hand::HandReading SimulatedHand::step(const hand::HandCommand& command) {
  const hand::ArmVector from = follower_ ? follower_->joints() : hand::ArmVector();
  apply(command);
  for (int i = 0; i < steps_a_tick_; ++i) {
    if (follower_) interpolate(from, static_cast<double>(i + 1) / steps_a_tick_);
    integrate(command);
    step_physics();
  }
  ++tick_;
  return read();
}

/// An arm's controller moves its setpoints within a tick, so that they do not jump.
void SimulatedHand::interpolate(const hand::ArmVector& from, double share) {
  const hand::ArmVector now = from + share * (follower_->joints() - from);
  for (Index i = 0; i < scene_.base_actuators.size(); ++i) {
    data_.ctrl[scene_.base_actuators[i]] = now[static_cast<int>(i)];
  }
}

void SimulatedHand::reset(const hand::HandCommand& command) {
  if (follower_) {
    follower_->reset(errors_.in_world(command.mount).pose(), hand::working_tour(hand_));
  }
  apply(command);
  const hand::JointVector joints =
      hand::joints_in_free_flexion(hand_, errors_.in_drives(command.positions));
  for (Index i = 0; i < scene_.joint_positions.size(); ++i) {
    data_.qpos[scene_.joint_positions[i]] = joints[static_cast<int>(i)];
  }
  for (Index i = 0; i < scene_.mount_positions.size(); ++i) {  // there already, and at rest
    data_.qpos[scene_.mount_positions[i]] = data_.ctrl[scene_.base_actuators[i]];
  }
  mj_kinematics(scene_.model.get(), &data_);  // for the centre of mass
  mj_comPos(scene_.model.get(), &data_);
  limits_ = floating_limits(scene_, data_, commanded_.xyz);
  integral_.reset();
  pushed_steps_ = 0;
  errors_.reset();
  if (biotacs_) biotacs_->reset();
  tick_ = 0;
}

hand::HandReading SimulatedHand::read() {
  RandomStream random = random_.fork("reading", tick_);
  hand::HandReading reading;
  reading.time = static_cast<double>(tick_) * hand::kTick;
  reading.joints.resize(hand_.joint_count());
  reading.torques.resize(hand_.actuator_count());
  reading.contacts.resize(hand_.fingers.size());
  for (int i = 0; i < hand_.joint_count(); ++i) {
    reading.joints[i] =
        data_.qpos[scene_.joint_positions[static_cast<Index>(i)]] + noise_.joint * random.normal();
  }
  for (int i = 0; i < hand_.actuator_count(); ++i) {
    reading.torques[i] = data_.actuator_force[scene_.actuators[static_cast<Index>(i)]];
  }
  read_mount(reading);
  RandomStream loads = random_.fork("load", tick_);
  reading.mount_force += noise_.load * loads.normal3();
  errors_.misread(reading);
  for (double& torque : reading.torques) torque += noise_.load * kTorqueLever * loads.normal();
  read_contacts(reading, random);
  RandomStream mount = random_.fork("mount", tick_);
  errors_.delay(reading, mount);
  return reading;
}

/// Of a floating mount its drives report; of an arm the encoders, and a sensor at the flange.
void SimulatedHand::read_mount(hand::HandReading& reading) {
  if (follower_) {
    hand::ArmVector joints(follower_->arm().joint_count());
    for (Index i = 0; i < scene_.mount_positions.size(); ++i) {
      joints[static_cast<int>(i)] = data_.qpos[scene_.mount_positions[i]];
    }
    reading.mount = hand::nearest_mount(hand::mount_pose(follower_->arm(), joints), commanded_);
    reading.mount_force = flange_force();
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<Index>(i);
    reading.mount.xyz[i] = data_.qpos[scene_.mount_positions[k]];
    reading.mount.ypr[i] = data_.qpos[scene_.mount_positions[k + 3]];
    reading.mount_force[i] = data_.actuator_force[scene_.base_actuators[k]];
  }
}

/// Force that the flange exerts on the hand, beyond the hand's weight.
Eigen::Vector3d SimulatedHand::flange_force() const {
  mj_rnePostConstraint(scene_.model.get(), &data_);
  const Eigen::Vector3d force = vector3(data_.cfrc_int + 6 * scene_.root + 3);
  return force + scene_.model->body_subtreemass[scene_.root] * vector3(scene_.model->opt.gravity);
}

void SimulatedHand::read_contacts(hand::HandReading& reading, RandomStream& random) {
  std::vector<TipLoad> loads(scene_.tips.size());
  const Eigen::Isometry3d T_object_world = body_pose(data_, scene_.object).inverse();
  for (Index i = 0; i < loads.size(); ++i) {
    const int link = scene_.model->geom_bodyid[scene_.tips[i]];
    loads[i].T_object_link = T_object_world * body_pose(data_, link);
  }
  const SensorNoise noise = errors_.white_noise();
  for (int i = 0; i < data_.ncon; ++i) {
    const auto touch = read_fingertip_touch(*scene_.model, data_, i, scene_.tips);
    if (!touch) continue;
    const bool of_object = scene_.model->geom_bodyid[touch->other_geom] == scene_.object;
    if (!scene_.is_sensed(touch->other_geom)) continue;
    const auto finger = static_cast<Index>(touch->finger);
    (of_object ? loads[finger].on_object : loads[finger].on_others).push_back(touch->contact);
    auto sensed = with_sensor_noise(touch->contact, noise, random);
    if (sensed && errors_.misread(finger, *sensed)) {
      reading.contacts[finger].push_back(*sensed);
    }
  }
  if (biotacs_) reading.biotacs = biotacs_->step(loads, reading.time);
}

}  // namespace palpate::simulation
