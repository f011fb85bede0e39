// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/joint_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "simulation/hand/model_checks.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {
namespace {

// The simulated friction and the misreading of torques grow with the limit, and hide contacts of a
// newton or two. The Shadow hand presses with up to 41 N by its limits, Allegro and LEAP with 24 N.
constexpr double kImplausiblePress = 60;                   // N at the fingertip
constexpr double kPlausiblePress = 18;                     // N, of a strong hand
constexpr double kMinStiffness = 0.5, kMaxStiffness = 12;  // N m/rad
constexpr double kNaturalFrequency = 40;                   // rad/s, of a joint on its servo
constexpr double kLeastPress = 1;          // N at the fingertip, to sense and hold anything
constexpr double kLeastAcceleration = 20;  // rad/s^2
constexpr double kHeaviest = 15;           // kg, of a hand with its forearm
constexpr double kGravity = 9.81;          // m/s^2
constexpr double kPassed = 0.1;            // rad by which followers may be led beyond limits
constexpr double kLeastLeft = 0.2;         // share of a joint's range that commands must reach
constexpr double kAsGoodAsAll = 0.9;       // share of it above which they differ by rounding
constexpr double kLeastArm = 0.03;         // m, of a drive that also carries loads from the side

/// The lesser of the two sides of a range that is not empty: a drive has it both ways.
double magnitude(const mjtNum* range) {
  const auto [less, more] = std::minmax({std::abs(range[0]), std::abs(range[1])});
  return less > 0 ? less : more;
}

/// Largest force of an actuator before its gear; infinite where the file does not say.
double force_limit(const mjModel& model, int actuator) {
  double limit = std::numeric_limits<double>::infinity();
  if (model.actuator_forcelimited[actuator]) {
    limit = magnitude(model.actuator_forcerange + 2 * actuator);
  }
  const bool integrates = model.actuator_dyntype[actuator] == mjDYN_INTEGRATOR;
  const bool is_motor = model.actuator_gaintype[actuator] == mjGAIN_FIXED &&
                        model.actuator_biastype[actuator] == mjBIAS_NONE && !integrates;
  if (is_motor && model.actuator_ctrllimited[actuator]) {
    limit = std::min(limit, std::abs(model.actuator_gainprm[mjNGAIN * actuator]) *
                                magnitude(model.actuator_ctrlrange + 2 * actuator));
  }
  return limit;
}

bool is_on_joint(const mjModel& model, int actuator, int joint) {
  const int type = model.actuator_trntype[actuator];
  return (type == mjTRN_JOINT || type == mjTRN_JOINTINPARENT) &&
         model.actuator_trnid[2 * actuator] == joint;
}

/// How far a tendon of joints moves a radian of one of them.
double tendon_coefficient(const mjModel& model, int tendon, int joint) {
  const int first = model.tendon_adr[tendon];
  for (int i = first; i < first + model.tendon_num[tendon]; ++i) {
    if (model.wrap_type[i] == mjWRAP_JOINT && model.wrap_objid[i] == joint) {
      return model.wrap_prm[i];
    }
  }
  return 0;
}

/// Torque on a joint over the actuator's force; 0: it does not drive the joint.
double gear_on(const mjModel& model, int actuator, int joint) {
  const double gear = std::abs(model.actuator_gear[6 * actuator]);
  if (is_on_joint(model, actuator, joint)) return gear;
  if (model.actuator_trntype[actuator] != mjTRN_TENDON) return 0;
  return gear * std::abs(tendon_coefficient(model, model.actuator_trnid[2 * actuator], joint));
}

/// kg, and how far from a joint's axis its middle is where the file draws it, m.
struct Carried {
  double mass, distance;
};

Carried carried_by(const mjModel& model, const mjData& data, int joint) {
  const int body = model.jnt_bodyid[joint];
  const Eigen::Vector3d offset =
      vector3(data.subtree_com + 3 * body) - vector3(data.xanchor + 3 * joint);
  const Eigen::Vector3d axis = vector3(data.xaxis + 3 * joint);
  return {model.body_subtreemass[body], (offset - offset.dot(axis) * axis).norm()};
}

DataHandle at_rest(const mjModel& model) {
  DataHandle data(mj_makeData(&model));
  if (!data) throw std::bad_alloc();
  mj_kinematics(&model, data.get());
  mj_comPos(&model, data.get());
  return data;
}

}  // namespace

double torque_limit(const mjModel& model, int joint) {
  double limit = std::numeric_limits<double>::infinity();
  if (model.jnt_actfrclimited[joint]) limit = magnitude(model.jnt_actfrcrange + 2 * joint);
  for (int i = 0; i < model.nu; ++i) {
    const double gear = gear_on(model, i, joint);
    if (gear > 0) limit = std::min(limit, gear * force_limit(model, i));
  }
  return std::isfinite(limit) ? limit : 0;
}

std::optional<hand::Range> commanded_range(const mjModel& model, int joint) {
  for (int i = 0; i < model.nu; ++i) {
    if (!is_on_joint(model, i, joint) || !model.actuator_ctrllimited[i]) continue;
    const mjtNum* const bias = model.actuator_biasprm + mjNBIAS * i;
    const double pull = bias[1] * model.actuator_gear[6 * i];  // of a radian of the joint
    if (model.actuator_gaintype[i] != mjGAIN_FIXED || model.actuator_biastype[i] != mjBIAS_AFFINE ||
        pull == 0) {
      continue;
    }
    const auto balanced = [&](double command) {
      return -(model.actuator_gainprm[mjNGAIN * i] * command + bias[0]) / pull;
    };
    const auto [low, high] = std::minmax(
        {balanced(model.actuator_ctrlrange[2 * i]), balanced(model.actuator_ctrlrange[2 * i + 1])});
    if (high > low) return hand::Range{low, high};
  }
  return {};
}

std::string limit_by_commands(const mjModel& model, int joint, hand::Actuator& actuator) {
  const auto commanded = commanded_range(model, joint);
  if (!commanded || (commanded->low == -1 && commanded->high == 1)) return {};
  hand::Range& range = actuator.command;
  const hand::Range both{std::max(range.low, commanded->low),
                         std::min(range.high, commanded->high)};
  const double share = (both.high - both.low) / (range.high - range.low);
  if (share < kLeastLeft || share > kAsGoodAsAll) return {};
  range = both;
  return fmt::format("{} moves from {:.2f} to {:.2f} rad, as far as the file's servo commands it",
                     actuator.name, range.low, range.high);
}

hand::Range range_with_followers(const hand::Description& hand, const hand::Actuator& actuator) {
  hand::Range range = actuator.command;
  for (std::size_t i = 1; i < actuator.joints.size(); ++i) {
    const auto& [joint, gear, share, offset] = actuator.joints[i];
    if (share == 0) continue;  // locked
    const hand::Range& own = hand.joints[static_cast<std::size_t>(joint)].range;
    const auto [low, high] = std::minmax({(own.low - offset) / share, (own.high - offset) / share});
    const double passed = kPassed / std::abs(share);
    if (range.low < low - passed) range.low = low;
    if (range.high > high + passed) range.high = high;
  }
  return range;
}

std::string led_fingers(const hand::Description& hand, const std::vector<int>& finger_of_joint) {
  int driven = 0;
  std::string led;
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const auto name = [&](int i) { return hand.fingers[static_cast<std::size_t>(i)].name; };
    if (std::ranges::count(hand.actuators, finger, &hand::Actuator::finger) > 0) {
      ++driven;
      continue;
    }
    const auto moves = [&](const hand::DrivenJoint& joint) {
      return joint.share != 0 && finger_of_joint[static_cast<std::size_t>(joint.joint)] == finger;
    };
    const auto drive = std::ranges::find_if(hand.actuators, [&](const hand::Actuator& one) {
      return std::ranges::any_of(one.joints, moves);
    });
    if (drive == hand.actuators.end()) {
      throw BadInput(fmt::format("no joint moves finger {} alone", name(finger)));
    }
    led = fmt::format("finger {} is moved only by the drive of {}", name(finger),
                      drive->finger < 0 ? "joint " + drive->name : "finger " + name(drive->finger));
  }
  if (!led.empty() && driven < 2) {
    throw BadInput(led + ": a hand with one drive for all its fingers is not supported");
  }
  return led;
}

void set_gains(const mjModel& model, const std::vector<int>& joint_ids,
               const hand::ActuatorVector& positions, hand::Description& hand) {
  const auto joints = hand::joints_in_free_flexion(hand, positions);
  for (hand::Actuator& one : hand.actuators) {
    if (one.finger >= 0) {
      const hand::Finger& finger = hand.fingers[static_cast<std::size_t>(one.finger)];
      const auto J = hand::jacobian(hand, joints, finger.link, finger.tip.b);
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (const auto& driven : one.joints) moved += driven.share * J.col(driven.joint).tail<3>();
      one.lever = std::max(0.01, moved.norm());
    } else {
      one.lever = 0.18;
    }
    one.stiffness = std::clamp(kTipStiffness * one.lever * one.lever, kMinStiffness, kMaxStiffness);
    one.armature = one.stiffness / (kNaturalFrequency * kNaturalFrequency);
    const int dof = model.jnt_dofadr[joint_ids[static_cast<std::size_t>(one.joints.front().joint)]];
    const double own = model.dof_M0[dof];
    one.damping = 2 * std::sqrt(one.stiffness * (one.armature + own));
  }
}

std::vector<HandProblem> check_drives(const mjModel& model, const std::vector<int>& joint_ids,
                                      bool given, const hand::Description& hand) {
  const DataHandle data = at_rest(model);
  std::vector<std::string> weak, overloaded, slow;
  double press = 0;
  for (const hand::Actuator& one : hand.actuators) {
    if (one.finger < 0) continue;
    const int joint = joint_ids[static_cast<std::size_t>(one.joints.front().joint)];
    const auto [mass, distance] = carried_by(model, *data, joint);
    if (one.closing != 0) press = std::max(press, one.max_torque / one.lever);
    if (one.closing != 0 && one.max_torque / one.lever < kLeastPress) weak.push_back(one.name);
    if (kGravity * mass * distance > one.max_torque) overloaded.push_back(one.name);
    const int dof = model.jnt_dofadr[joint];
    const double inertia = model.dof_M0[dof] - model.dof_armature[dof] + one.armature;
    if (one.max_torque / inertia < kLeastAcceleration) slow.push_back(one.name);
  }
  std::vector<HandProblem> problems;
  const auto add = [&](const std::vector<std::string>& joints, const std::string& what,
                       const char* hint) {
    if (!joints.empty())
      problems.push_back({fmt::format("drives of {} {}", first_of(joints), what), hint});
  };
  add(weak, fmt::format("press with less than {} N at the fingertip", kLeastPress),
      "see the torque limits: effort, forcerange and gear of the file, max_torque in a TOML file");
  add(overloaded, "do not carry the weight of their links", "compare masses and torque limits");
  add(slow, fmt::format("accelerate their links by less than {} rad/s^2", kLeastAcceleration),
      "compare inertias (kg m^2) and torque limits");
  if (given && press > kImplausiblePress) {
    problems.push_back({fmt::format("max_torque presses with {:.0f} N at the fingertip", press),
                        "touches of some newtons are lost in a drive's friction, which is taken to "
                        "grow with its limit"});
  }
  if (const double mass = model.body_subtreemass[0]; mass > kHeaviest) {
    problems.push_back(
        {fmt::format("the hand has a mass of {:.3g} kg", mass), "compare its links'"});
  }
  return problems;
}

std::string lower_torque_limits(hand::Description& hand) {
  double press = 0, was = 0, least = std::numeric_limits<double>::infinity(), most = 0;
  for (const hand::Actuator& one : hand.actuators) {
    if (one.closing != 0) press = std::max(press, one.max_torque / one.lever);
    was = std::max(was, one.max_torque);
  }
  if (press <= kImplausiblePress) return {};
  for (hand::Actuator& one : hand.actuators) {
    one.max_torque = std::min(one.max_torque, kPlausiblePress * std::max(one.lever, kLeastArm));
    least = std::min(least, one.max_torque);
    most = std::max(most, one.max_torque);
  }
  return fmt::format(
      "torque limits of {:.4g} N m would press with {:.0f} N: {:.2f} to {:.2f} N m are used; "
      "max_torque in a TOML file sets another",
      was, press, least, most);
}

}  // namespace palpate::simulation
