// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/faulty_hand.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/hand/tip_forces.hpp"

namespace palpate::hand {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kGap = 0.2;          // s
constexpr std::size_t kDelay = 20;    // readings
constexpr double kJitter = 0.003;     // s
constexpr double kFalseShare = 0.1;   // of the readings of a fingertip
constexpr double kTaxelSize = 0.004;  // m around it in which nothing is sensed
constexpr double kSaturated = 30;     // N

TipContact contact_of(double force) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  return {0.02 * up, up, -force * up};
}

bool is_of_load(InjectedFault fault) {
  return fault == InjectedFault::load_nan || fault == InjectedFault::load_zero ||
         fault == InjectedFault::load_frozen;
}

bool is_of_finger(InjectedFault fault) {
  return fault == InjectedFault::finger_silent || fault == InjectedFault::finger_stuck ||
         fault == InjectedFault::finger_nan || fault == InjectedFault::finger_saturated ||
         fault == InjectedFault::fingers_swapped || fault == InjectedFault::taxel_dead;
}

}  // namespace

std::string_view to_string(InjectedFault fault) {
  return kInjectedFaultNames[static_cast<std::size_t>(fault)];
}

InjectedFault injected_fault(std::string_view name) {
  const auto found = std::find(kInjectedFaultNames.begin(), kInjectedFaultNames.end(), name);
  if (found == kInjectedFaultNames.end()) {
    const std::vector<std::string> names(kInjectedFaultNames.begin(), kInjectedFaultNames.end());
    const std::string likely = did_you_mean(name, names);
    throw BadInput(fmt::format(
        "there is no fault '{}'{}", name,
        likely.empty() ? fmt::format("; the faults are {}", fmt::join(names, ", ")) : likely));
  }
  return static_cast<InjectedFault>(found - kInjectedFaultNames.begin());
}

FaultyHand::FaultyHand(Hand& hand, const FaultSchedule& schedule, std::function<void()> on_onset)
    : hand_(hand),
      schedule_(schedule),
      on_onset_(std::move(on_onset)),
      random_(schedule.seed, "hand fault") {}

HandReading FaultyHand::step(const HandCommand& command) {
  return spoilt(hand_.step(began_ && !ended_ ? obeyed(command) : command));
}

std::optional<HandReading> FaultyHand::sense() {
  std::optional<HandReading> reading = hand_.sense();
  if (reading) reading = spoilt(*reading);
  return reading;
}

HandReading FaultyHand::spoilt(const HandReading& reading) {
  measure(reading);
  if (schedule_.fault == InjectedFault::none || reading.time < schedule_.from) {
    before_ = reading;
    return reading;
  }
  if (!began_) set_in(reading);
  ended_ = ended_ || reading.time >= *began_ + schedule_.length;
  return ended_ ? reading : falsified(reading);
}

void FaultyHand::set_in(const HandReading& reading) {
  const auto require = [](std::string_view what, int index, Eigen::Index count) {
    if (index >= 0 && index < count) return;
    throw BadInput(fmt::format("a fault of {} {} of a hand that has {}", what, index, count));
  };
  if (is_of_finger(schedule_.fault)) {
    require("finger", schedule_.finger, std::ssize(reading.contacts));
  }
  if (schedule_.fault == InjectedFault::joint_nan) {
    require("joint", schedule_.joint, reading.joints.size());
  }
  if (schedule_.fault == InjectedFault::joint_stuck) {
    require("actuator", schedule_.actuator, reading.torques.size());
  }
  began_ = reading.time;
  if (on_onset_) on_onset_();
}

void FaultyHand::measure(const HandReading& reading) {
  peak_load_ = std::max(peak_load_, reading.mount_force.norm());
  for (int finger = 0; finger < static_cast<int>(reading.contacts.size()); ++finger) {
    peak_tip_force_ = std::max(peak_tip_force_, tip_force(reading, finger));
  }
}

HandCommand FaultyHand::obeyed(const HandCommand& command) {
  HandCommand result = command;
  if (!stuck_at_) stuck_at_ = command;
  if (schedule_.fault == InjectedFault::joint_stuck) {
    result.positions[schedule_.actuator] = stuck_at_->positions[schedule_.actuator];
  }
  if (schedule_.fault == InjectedFault::mount_stuck) result.mount = stuck_at_->mount;
  return result;
}

/// What is repeated where the fault was there from the first: nothing but zeros.
void FaultyHand::begin_with_nothing(const HandReading& reading) {
  if (before_.joints.size() == reading.joints.size()) return;
  before_.joints.setZero(reading.joints.size());
  before_.torques.setZero(reading.torques.size());
  before_.contacts.resize(reading.contacts.size());
}

HandReading FaultyHand::falsified(const HandReading& reading) {
  begin_with_nothing(reading);
  HandReading result = spoil_link(reading);
  if (is_of_load(schedule_.fault)) spoil_load(result);
  spoil_contacts(result);
  if (schedule_.fault == InjectedFault::joint_nan) result.joints[schedule_.joint] = kNan;
  if (schedule_.fault == InjectedFault::torques_zero) result.torques.setZero();
  return result;
}

void FaultyHand::spoil_load(HandReading& reading) const {
  if (schedule_.fault == InjectedFault::load_nan) reading.mount_force.setConstant(kNan);
  if (schedule_.fault == InjectedFault::load_zero) reading.mount_force.setZero();
  if (schedule_.fault == InjectedFault::load_frozen) reading.mount_force = before_.mount_force;
}

void FaultyHand::spoil_contacts(HandReading& reading) {
  auto& contacts = reading.contacts;
  switch (schedule_.fault) {
    case InjectedFault::contacts_nan:
      for (auto& tip : contacts) tip.assign(1, contact_of(kNan));
      break;
    case InjectedFault::contacts_none:
      for (auto& tip : contacts) tip.clear();
      break;
    case InjectedFault::fingers_swapped: {
      const auto finger = static_cast<std::size_t>(schedule_.finger);
      std::swap(contacts[finger], contacts[(finger + 1) % contacts.size()]);
      break;
    }
    case InjectedFault::false_contacts:
      for (auto& tip : contacts) {
        if (random_.uniform() < kFalseShare) tip.push_back(contact_of(1));
      }
      break;
    default:
      if (is_of_finger(schedule_.fault)) {
        spoil_finger(contacts[static_cast<std::size_t>(schedule_.finger)]);
      }
  }
}

void FaultyHand::spoil_finger(std::vector<TipContact>& contacts) {
  switch (schedule_.fault) {
    case InjectedFault::finger_silent:
      contacts.clear();
      break;
    case InjectedFault::finger_stuck:
      contacts = before_.contacts[static_cast<std::size_t>(schedule_.finger)];
      break;
    case InjectedFault::finger_nan:
      contacts.assign(1, contact_of(kNan));
      break;
    case InjectedFault::finger_saturated:
      contacts.assign(1, contact_of(kSaturated));
      break;
    case InjectedFault::taxel_dead:
      if (!taxel_ && !contacts.empty()) taxel_ = contacts.front().p;
      std::erase_if(contacts, [this](const TipContact& contact) {
        return (contact.p - *taxel_).norm() < kTaxelSize;
      });
      break;
    default:
      break;
  }
}

HandReading FaultyHand::spoil_link(const HandReading& reading) {
  HandReading result = reading;
  switch (schedule_.fault) {
    case InjectedFault::readings_stuck:
      result = before_;
      result.time = reading.time;
      break;
    case InjectedFault::link_gap:
      if (reading.time > *began_ + kGap) break;
      [[fallthrough]];
    case InjectedFault::link_dead:
      result = before_;
      break;
    case InjectedFault::time_nan:
      result.time = kNan;
      break;
    case InjectedFault::time_jitter:
      result.time += kJitter * random_.uniform(-1, 1);
      break;
    case InjectedFault::delay:
      queue_.push_back(reading);
      result = queue_.size() > kDelay ? queue_.front() : before_;
      if (queue_.size() > kDelay) queue_.pop_front();
      break;
    case InjectedFault::throws:
      throw std::runtime_error("the link to the hand is lost");
    default:
      break;
  }
  return result;
}

}  // namespace palpate::hand
