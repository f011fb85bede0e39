// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_touch.hpp"

#include <fmt/format.h>

#include <array>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "simulation/contact/fingertip_touch.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "tasks/relocate/relocate_model.hpp"
#include "tasks/relocate/task_arm.hpp"

namespace palpate::relocate {
namespace {

/// Where each joint of the Shadow hand, in the order of hand::kShadowJointNames, is among the
/// Adroit hand's, and which way round its axis is there.
struct Twin {
  const char* name;  ///< in the Adroit hand
  int joint;
  double sign;
};
constexpr std::array<Twin, hand::kShadowJoints> kTwins = {{
    {"WRJ1", 6, 1},   {"WRJ0", 7, 1},  //
    {"THJ4", 25, 1},  {"THJ3", 26, 1}, {"THJ2", 27, 1}, {"THJ1", 28, -1}, {"THJ0", 29, -1},
    {"FFJ3", 8, -1},  {"FFJ2", 9, 1},  {"FFJ1", 10, 1}, {"FFJ0", 11, 1},  //
    {"MFJ3", 12, -1}, {"MFJ2", 13, 1}, {"MFJ1", 14, 1}, {"MFJ0", 15, 1},  //
    {"RFJ3", 16, 1},  {"RFJ2", 17, 1}, {"RFJ1", 18, 1}, {"RFJ0", 19, 1},  //
    {"LFJ4", 20, 1},  {"LFJ3", 21, 1}, {"LFJ2", 22, 1}, {"LFJ1", 23, 1},  {"LFJ0", 24, 1},
}};

simulation::NamedJoint twin_of(const std::string& name) {
  for (std::size_t i = 0; i < kTwins.size(); ++i) {
    if (kTwins[i].name == name) return {static_cast<int>(i), kTwins[i].sign};
  }
  throw BadInput(fmt::format("the Adroit hand has no joint {}", name));
}

const mjModel& compiled(const RelocateModel& model) { return *model.impl().scene.model; }

int forearm(const RelocateModel& model) {
  return simulation::find_id(compiled(model), mjOBJ_BODY, "forearm");
}

const std::vector<int>& tips_of(const RelocateModel& model) { return model.impl().scene.tips; }

/// Force on the hand of all that it touches, world axes, N.
Eigen::Vector3d contact_force(const RelocateScene& scene, const mjData& data) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.geom[0] < 0 || contact.geom[1] < 0) continue;
    const bool first = scene.hand[static_cast<std::size_t>(contact.geom[0])] != 0;
    const bool second = scene.hand[static_cast<std::size_t>(contact.geom[1])] != 0;
    if (first == second) continue;
    std::array<mjtNum, 6> force{};  // on the second, along the contact's axes, which are rows
    mj_contactForce(scene.model.get(), &data, i, force.data());
    const Eigen::Vector3d f =
        Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>>(contact.frame).transpose() *
        simulation::vector3(force.data());
    sum += second ? f : Eigen::Vector3d(-f);
  }
  return sum;
}

/// Torques of the actuators, N m: of a coupled pair the sum of both joints'.
hand::ActuatorVector torques_of(const hand::Description& hand, const mjData& data) {
  hand::ActuatorVector torques = hand::ActuatorVector::Zero(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    for (const auto& driven : hand.actuators[static_cast<std::size_t>(i)].joints) {
      const Twin& twin = kTwins.at(static_cast<std::size_t>(driven.joint));
      torques[i] += twin.sign * data.actuator_force[twin.joint];
    }
  }
  return torques;
}

/// Its first finger is bent down at the knuckle, the others are stretched: the arm cannot turn far
/// enough to point down with a stretched finger.
hand::PointingHand pointing_task_hand(const hand::Description& hand) {
  constexpr double kKnuckle = 1.0, kDown = 0.35;  // rad
  hand::PointingHand pointing;
  pointing.finger = 1;
  pointing.positions = hand.postures.stretched;
  pointing.positions[hand.actuator("FFJ3")] = kKnuckle;
  pointing.attitude = {.pitch = 0, .roll = -kDown};
  return pointing;
}

}  // namespace

hand::JointVector shadow_joints(const RelocateJoints& joints) {
  hand::JointVector result(static_cast<Eigen::Index>(kTwins.size()));
  for (std::size_t i = 0; i < kTwins.size(); ++i) {
    result[static_cast<Eigen::Index>(i)] = kTwins[i].sign * joints[kTwins[i].joint];
  }
  return result;
}

RelocateJoints task_joints(const hand::JointVector& shadow_joints) {
  RelocateJoints result = RelocateJoints::Zero();
  for (std::size_t i = 0; i < kTwins.size(); ++i) {
    result[kTwins[i].joint] = kTwins[i].sign * shadow_joints[static_cast<Eigen::Index>(i)];
  }
  return result;
}

hand::Description adroit_hand_model(const RelocateModel& model) {
  hand::Description hand = hand::shadow_hand();
  simulation::read_links(compiled(model), forearm(model), "palm", twin_of, tips_of(model), hand);
  hand.links.front().T_parent_link.setIdentity();
  hand.links.front().T_parent_link.linear() = TaskArm(model).R_mount_forearm();
  hand.postures.pointing = {pointing_task_hand(hand)};
  return hand;
}

RelocateTouch::RelocateTouch(const RelocateModel& model, const simulation::SensorNoise& noise,
                             std::uint64_t seed)
    : noise_(noise),
      random_(seed, "relocate touch"),
      hand_(adroit_hand_model(model)),
      arm_(std::make_shared<TaskArm>(model)),
      tips_(tips_of(model)) {
  RandomStream links = random_.fork("links");
  hand_ = hand::with_perturbed_links(std::move(hand_), noise.link, links);
}

hand::HandReading RelocateTouch::read(const RelocateTask& task, int step) const {
  RandomStream random = random_.fork("reading", static_cast<std::uint64_t>(step));
  const RelocateTask::Impl& state = task.impl();
  const mjModel& model = *state.scene().model;
  constexpr double kTorqueLever = 0.025;  // m, noise of the torques over that of the load
  hand::HandReading reading;
  reading.time = step * hand::kTick;
  const RelocateJoints q = RelocateJoints::Map(state.data->qpos);
  reading.joints = shadow_joints(q);
  reading.torques = torques_of(hand_, *state.data);
  reading.mount_force = -contact_force(state.scene(), *state.data);
  reading.contacts.resize(hand_.fingers.size());
  for (double& angle : reading.joints) angle += noise_.joint * random.normal();
  reading.mount = arm_->mount(q);
  for (int i = 0; i < state.data->ncon; ++i) {
    const auto touch = simulation::read_fingertip_touch(model, *state.data, i, tips_);
    if (!touch || model.geom_bodyid[touch->other_geom] != state.scene().object) continue;
    if (const auto sensed = simulation::with_sensor_noise(touch->contact, noise_, random)) {
      reading.contacts[static_cast<std::size_t>(touch->finger)].push_back(*sensed);
    }
  }
  reading.mount_force += noise_.load * random.normal3();
  for (double& torque : reading.torques) torque += noise_.load * kTorqueLever * random.normal();
  return reading;
}

}  // namespace palpate::relocate
