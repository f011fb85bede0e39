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

/// Where the arm's joints put the forearm: slides along its resting axes, then hinges about its
/// own.
Eigen::Isometry3d forearm_at(const mjModel& model, int forearm, const RelocateJoints& q) {
  return simulation::pose3(model.body_pos + 3 * forearm, model.body_quat + 4 * forearm) *
         Eigen::Translation3d(q.head<3>()) * Eigen::AngleAxisd(q[3], Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(q[4], Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(q[5], Eigen::Vector3d::UnitZ());
}

}  // namespace

hand::JointVector shadow_joints(const RelocateJoints& joints) {
  hand::JointVector result(static_cast<Eigen::Index>(kTwins.size()));
  for (std::size_t i = 0; i < kTwins.size(); ++i) {
    result[static_cast<Eigen::Index>(i)] = kTwins[i].sign * joints[kTwins[i].joint];
  }
  return result;
}

hand::Description adroit_hand_model(const RelocateModel& model) {
  hand::Description hand = hand::shadow_hand();
  simulation::read_links(compiled(model), forearm(model), "palm", twin_of, tips_of(model), hand);
  hand.links.front().T_parent_link.setIdentity();
  return hand;
}

RelocateTouch::RelocateTouch(const RelocateModel& model, const simulation::SensorNoise& noise,
                             std::uint64_t seed)
    : noise_(noise),
      random_(seed, "relocate touch"),
      hand_(adroit_hand_model(model)),
      mount_(forearm(model)),
      tips_(tips_of(model)) {
  RandomStream links = random_.fork("links");
  hand_ = hand::with_perturbed_links(std::move(hand_), noise.link, links);
}

hand::HandReading RelocateTouch::read(const RelocateTask& task, int step) const {
  RandomStream random = random_.fork("reading", static_cast<std::uint64_t>(step));
  const RelocateTask::Impl& state = task.impl();
  const mjModel& model = *state.scene().model;
  hand::HandReading reading;
  reading.time = step * hand::kTick;
  const RelocateJoints q = RelocateJoints::Map(state.data->qpos);
  reading.joints = shadow_joints(q);
  reading.torques.setZero(hand_.actuator_count());
  reading.contacts.resize(hand_.fingers.size());
  for (double& angle : reading.joints) angle += noise_.joint * random.normal();
  reading.mount = hand::MountPosition::at(forearm_at(model, mount_, q));
  for (int i = 0; i < state.data->ncon; ++i) {
    const auto touch = simulation::read_fingertip_touch(model, *state.data, i, tips_);
    if (!touch || model.geom_bodyid[touch->other_geom] != state.scene().object) continue;
    if (const auto sensed = simulation::with_sensor_noise(touch->contact, noise_, random)) {
      reading.contacts[static_cast<std::size_t>(touch->finger)].push_back(*sensed);
    }
  }
  return reading;
}

}  // namespace palpate::relocate
