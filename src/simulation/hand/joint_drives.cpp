// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/joint_drives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"

namespace palpate::simulation {
namespace {

// The simulated friction and the misreading of torques grow with the limit, and hide contacts of a
// newton or two. The Shadow hand presses with up to 41 N by its limits, Allegro and LEAP with 24 N.
constexpr double kImplausiblePress = 60;  // N at the fingertip
constexpr double kPlausiblePress = 18;    // N, of a strong hand
constexpr double kPassed = 0.1;           // rad by which followers may be led beyond limits
constexpr double kLeastLeft = 0.2;        // share of a joint's range that commands must reach
constexpr double kAsGoodAsAll = 0.9;      // share of it above which they differ by rounding
constexpr double kLeastArm = 0.03;        // m, of a drive that also carries loads from the side

double greatest(const mjtNum* range) { return std::max(std::abs(range[0]), std::abs(range[1])); }

/// Largest force of an actuator before its gear; infinite where the file does not say.
double force_limit(const mjModel& model, int actuator) {
  double limit = std::numeric_limits<double>::infinity();
  if (model.actuator_forcelimited[actuator]) {
    limit = greatest(model.actuator_forcerange + 2 * actuator);
  }
  const bool integrates = model.actuator_dyntype[actuator] == mjDYN_INTEGRATOR;
  const bool is_motor = model.actuator_gaintype[actuator] == mjGAIN_FIXED &&
                        model.actuator_biastype[actuator] == mjBIAS_NONE && !integrates;
  if (is_motor && model.actuator_ctrllimited[actuator]) {
    limit = std::min(limit, std::abs(model.actuator_gainprm[mjNGAIN * actuator]) *
                                greatest(model.actuator_ctrlrange + 2 * actuator));
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

}  // namespace

double torque_limit(const mjModel& model, int joint) {
  double limit = std::numeric_limits<double>::infinity();
  if (model.jnt_actfrclimited[joint]) limit = greatest(model.jnt_actfrcrange + 2 * joint);
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
