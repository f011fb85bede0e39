// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/reading_gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "skills/safety/unsensed_force.hpp"

namespace palpate::skills {
namespace {

constexpr double kClockDrift = 1e-3;    // of the hand's clock against the ticks, that is allowed
constexpr double kStandsStill = 0.1;    // rad within which a joint counts as standing still
constexpr double kMountStands = 0.002;  // m within which the mount counts as standing still
constexpr double kSoft = 1.2;           // times the lead that gives the torque that is allowed
constexpr double kOverRange = 2;        // times a fingertip's range, of forces that are believed
constexpr double kSensedForce = 0.1;    // N at which a fingertip senses something
constexpr double kLongOff = 4;        // tracking times for which what moves may be off its command
constexpr double kNormalError = 0.1;  // of the length of a unit normal

bool finite(const hand::HandReading& reading) {
  return reading.joints.allFinite() && reading.torques.allFinite() &&
         reading.mount.xyz.allFinite() && reading.mount.ypr.allFinite() &&
         reading.mount_force.allFinite();
}

bool same(const std::vector<hand::TipContact>& a, const std::vector<hand::TipContact>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return x.p == y.p && x.f == y.f; });
}

/// A unit vector, or nothing.
bool is_normal(const Eigen::Vector3d& n) {
  return n.isZero(0) || std::abs(n.norm() - 1) <= kNormalError;
}

bool believable(const hand::TipContact& contact, const hand::Finger& finger,
                const SafetyOptions& options) {
  return contact.p.allFinite() && is_normal(contact.n) && contact.f.allFinite() &&
         std::isfinite(contact.point_sigma) && std::isfinite(contact.normal_sigma) &&
         contact.f.norm() <= kOverRange * options.tip_force_range &&
         hand::distance_from_tip(contact.p, finger) <= options.tip_reach;
}

double turn_off(const hand::MountPosition& a, const hand::MountPosition& b) {
  return Eigen::AngleAxisd(a.pose().linear().transpose() * b.pose().linear()).angle();
}

/// A fingertip that presses harder than its sensor can read touches all the more.
void limit_force(hand::TipContact& contact, double force_range) {
  const double force = contact.f.norm();
  if (force > force_range) contact.f *= force_range / force;
}

/// What a driver gives that has not heard of its hand yet.
bool is_blank(const hand::HandReading& reading) {
  return reading.joints.isZero(0) && reading.torques.isZero(0) && reading.mount.xyz.isZero(0) &&
         reading.mount.ypr.isZero(0);
}

}  // namespace

ReadingGate::ReadingGate(const hand::Description& hand, const SafetyOptions& options)
    : hand_(hand),
      options_(options),
      rest_positions_(hand::ActuatorVector::Zero(hand.actuator_count())),
      allowed_errors_(rest_positions_),
      astray_(hand.actuators.size()),
      off_(hand.actuators.size()) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const double torque = unsensed_torque(actuator, options.unsensed_force);
    allowed_errors_[i] = std::max(options.tracking_error, kSoft * torque / actuator.stiffness);
  }
}

/// What of a reading is not finite, in words.
std::string ReadingGate::not_finite(const hand::HandReading& reading) const {
  for (Eigen::Index i = 0; i < reading.joints.size(); ++i) {
    if (!std::isfinite(reading.joints[i])) {
      return fmt::format("joint {} reads {}", hand_.joints[static_cast<std::size_t>(i)].name,
                         reading.joints[i]);
    }
  }
  for (Eigen::Index i = 0; i < reading.torques.size(); ++i) {
    if (!std::isfinite(reading.torques[i])) {
      return fmt::format("the torque of {} reads {}",
                         hand_.actuators[static_cast<std::size_t>(i)].name, reading.torques[i]);
    }
  }
  const bool load = !reading.mount_force.allFinite();
  const Eigen::Vector3d& value = load ? reading.mount_force : reading.mount.xyz;
  return fmt::format("the {} reads {} {} {}", load ? "mount's load" : "mount", value.x(), value.y(),
                     value.z());
}

/// Which part of a reading is not of the hand's size, in words.
std::string ReadingGate::wrong_size(const hand::HandReading& reading) const {
  const auto complain = [](std::string_view what, std::size_t read, std::size_t has) {
    return read == has ? std::string()
                       : fmt::format("{} {} were read, the hand has {}", read, what, has);
  };
  for (const std::string& fault :
       {complain("joints", static_cast<std::size_t>(reading.joints.size()), hand_.joints.size()),
        complain("torques", static_cast<std::size_t>(reading.torques.size()),
                 hand_.actuators.size()),
        complain("fingertips", reading.contacts.size(), hand_.fingers.size())}) {
    if (!fault.empty()) return fault;
  }
  return {};
}

ReadingCheck ReadingGate::check(hand::HandReading& reading, const StepReport& step,
                                const hand::HandCommand& command) {
  ++tick_;
  if (const ReadingCheck check = check_time(reading.time, step.pause); !check.usable) return check;
  if (const ReadingCheck check = check_values(reading); !check.usable) return check;
  for (const ReadingCheck& check :
       {check_repeats(reading, step.sensed_load), check_touch(reading, step.trust),
        check_load(reading), check_tracking(reading, command), check_mount(reading, command)}) {
    if (check.fault != Fault::none) return check;
  }
  const bool first = !last_;
  last_ = reading;
  last_load_ = step.sensed_load;
  last_tick_ = tick_;
  return first ? check_start(reading, command, step.commanded) : ReadingCheck{};
}

/// A clock that is not the hand's: its ticks. How far they lead the hand's clock at best is known
/// from the readings so far, and may change slowly. A hand with a clock of its own goes on while
/// none is asked of it.
ReadingCheck ReadingGate::check_time(double time, double pause) {
  const double now = static_cast<double>(tick_) * hand::kTick;
  const bool first = !last_;
  const bool known = std::isfinite(time);
  const bool fresh = known && (first || time > last_->time);
  if (first) {
    first_time_ = time;
    first_now_ = now;
  }
  if (fresh) lead_ = first ? now - time : std::min(lead_ + kClockDrift * hand::kTick, now - time);
  const double age = known ? now - time - lead_ : 0;
  if (fresh && age <= options_.max_age) {
    if (!first && time - last_->time > options_.max_gap + options_.max_age + pause) {
      return {false, Fault::implausible_change,
              fmt::format("the hand's clock went from {} to {} s", last_->time, time)};
    }
    return {};
  }
  const double gap = hand::kTick * static_cast<double>(tick_ - last_tick_);
  const double allowed = known ? options_.max_gap : hand::kTick * options_.max_bad;
  if (gap < allowed) return {false, Fault::none, {}};
  if (!known) return {false, Fault::not_finite, fmt::format("the time reads {}", time)};
  if (fresh) return {false, Fault::late, late_by(age, now, time)};
  return {false, Fault::silent, fmt::format("no new reading for {:.2f} s", gap)};
}

/// Why readings are late: they come late, or the hand's clock is slower than the ticks.
std::string ReadingGate::late_by(double age, double now, double time) const {
  return fmt::format("readings are {:.2f} s old: the hand's clock went on by {:.2f} s in {:.2f} s",
                     age, time - first_time_, now - first_now_);
}

ReadingCheck ReadingGate::check_values(const hand::HandReading& reading) {
  Fault fault = Fault::none;
  const std::string detail = impossible_value(reading, fault);
  bad_ = fault == Fault::none ? 0 : bad_ + 1;
  if (fault == Fault::none) return {};
  if (bad_ < options_.max_bad) return {false, Fault::none, {}};
  return {false, fault, detail};
}

std::string ReadingGate::impossible_value(const hand::HandReading& reading, Fault& fault) const {
  fault = Fault::out_of_range;
  if (std::string wrong = wrong_size(reading); !wrong.empty()) return wrong;
  fault = Fault::not_finite;
  if (!finite(reading)) return not_finite(reading);
  fault = Fault::out_of_range;
  const hand::ActuatorVector positions = hand::actuator_positions(hand_, reading.joints);
  for (int i = 0; i < hand_.actuator_count(); ++i) {
    const hand::Range& range = hand_.actuators[static_cast<std::size_t>(i)].command;
    if (positions[i] >= range.low - options_.joint_margin &&
        positions[i] <= range.high + options_.joint_margin) {
      continue;
    }
    return fmt::format("{} reads {:.3f} rad, its range is {:.3f} to {:.3f}",
                       hand_.actuators[static_cast<std::size_t>(i)].name, positions[i], range.low,
                       range.high);
  }
  const double reach = reading.mount.xyz.norm(), load = reading.mount_force.norm();
  if (reach > options_.workspace + options_.mount_jump) {
    return fmt::format("the mount reads {:.3f} m from the origin", reach);
  }
  if (load > options_.load_range) return fmt::format("the mount's load reads {:.1f} N", load);
  fault = Fault::implausible_change;
  std::string jumped = jump(reading);
  if (jumped.empty()) fault = Fault::none;
  return jumped;
}

std::string ReadingGate::jump(const hand::HandReading& reading) const {
  if (!last_) return {};
  Eigen::Index joint = 0;
  const double turned = (reading.joints - last_->joints).cwiseAbs().maxCoeff(&joint);
  const double moved = (reading.mount.xyz - last_->mount.xyz).norm();
  if (turned > options_.joint_jump) {
    return fmt::format("joint {} jumped by {:.3f} rad",
                       hand_.joints[static_cast<std::size_t>(joint)].name, turned);
  }
  if (moved > options_.mount_jump) return fmt::format("the mount jumped by {:.3f} m", moved);
  return {};
}

/// No sensor reads the same twice, to the last bit.
ReadingCheck ReadingGate::check_repeats(const hand::HandReading& reading,
                                        const Eigen::Vector3d& sensed_load) {
  if (!last_) return {};
  const auto count = [](bool repeats, int& times) { times = repeats ? times + 1 : 0; };
  count(reading.joints == last_->joints, same_joints_);
  count(reading.torques == last_->torques, same_torques_);
  count(sensed_load == last_load_, same_load_);
  const char* const what = same_joints_ >= options_.max_repeats    ? "joints"
                           : same_torques_ >= options_.max_repeats ? "torques"
                           : same_load_ >= options_.max_repeats    ? "the mount's load"
                                                                   : nullptr;
  if (!what) return {};
  return {true, Fault::frozen,
          fmt::format("{} repeat the same values for {} readings", what, options_.max_repeats)};
}

/// A fingertip whose contacts are impossible, or repeat themselves, is one that senses nothing.
ReadingCheck ReadingGate::check_touch(hand::HandReading& reading, const FingerTrust& trust) {
  int usable = 0;
  for (std::size_t finger = 0; finger < hand_.fingers.size(); ++finger) {
    auto& contacts = reading.contacts[finger];
    const bool repeats = !contacts.empty() && same(contacts, last_contacts_[finger]);
    same_contacts_[finger] = repeats ? same_contacts_[finger] + 1 : 0;
    last_contacts_[finger] = contacts;
    const bool possible =
        std::all_of(contacts.begin(), contacts.end(), [&](const hand::TipContact& contact) {
          return believable(contact, hand_.fingers[finger], options_);
        });
    const bool ok = possible && same_contacts_[finger] < options_.max_repeats &&
                    trust.trusted(static_cast<int>(finger));
    if (!ok) contacts.clear();
    for (hand::TipContact& contact : contacts) limit_force(contact, options_.tip_force_range);
    flicker_.filter(static_cast<int>(finger), contacts);
    usable += ok;
  }
  touchless_ = usable == 0 ? touchless_ + 1 : 0;
  if (touchless_ < options_.max_bad) return {};
  return {true, Fault::touch_lost, "no fingertip's sensor can be believed"};
}

ReadingCheck ReadingGate::check_load(const hand::HandReading& reading) {
  const double load = reading.mount_force.norm();
  if (load <= options_.max_load) return {};
  const bool sensed = hand::count_contacts(reading, kSensedForce) > 0;
  return {true, sensed ? Fault::excess_force : Fault::unsensed_load,
          fmt::format("the mount bears {:.1f} N of at most {:.1f}{}", load, options_.max_load,
                      sensed ? "" : ", and no fingertip has a contact")};
}

/// A finger that presses on something is held up by that, not stuck.
bool ReadingGate::presses(const hand::HandReading& reading, int actuator) const {
  const int finger = hand_.actuators[static_cast<std::size_t>(actuator)].finger;
  return finger >= 0 && !reading.contacts[static_cast<std::size_t>(finger)].empty();
}

ReadingCheck ReadingGate::check_tracking(const hand::HandReading& reading,
                                         const hand::HandCommand& command) {
  const hand::ActuatorVector positions = hand::actuator_positions(hand_, reading.joints);
  for (int i = 0; i < hand_.actuator_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double error = command.positions[i] - positions[i];
    const bool stands = std::abs(positions[i] - rest_positions_[i]) < kStandsStill;
    const bool follows = presses(reading, i) || std::abs(error) < allowed_errors_[i];
    off_[k] = follows ? 0 : off_[k] + 1;
    astray_[k] = follows || !stands ? 0 : astray_[k] + 1;
    if (astray_[k] == 0) rest_positions_[i] = positions[i];
    if (const char* const how = astray(astray_[k], off_[k])) {
      return {true, Fault::joint_stuck,
              fmt::format("{} {} at {:.2f} rad, commanded to {:.2f}", hand_.actuators[k].name, how,
                          positions[i], command.positions[i])};
    }
  }
  return {};
}

/// How something has been off its command for too many ticks, `still` of them standing still;
/// nothing where it has not.
const char* ReadingGate::astray(int still, int off) const {
  if (hand::kTick * still >= options_.tracking_time) return "stands";
  return hand::kTick * off >= kLongOff * options_.tracking_time ? "moves" : nullptr;
}

/// What carries the hand follows its command, too.
ReadingCheck ReadingGate::check_mount(const hand::HandReading& reading,
                                      const hand::HandCommand& command) {
  const double off = (command.mount.xyz - reading.mount.xyz).norm();
  const double turned = turn_off(command.mount, reading.mount);
  const bool stands = (reading.mount.xyz - mount_rest_).norm() < kMountStands;
  const bool follows = off < options_.mount_error && turned < options_.tracking_error;
  mount_off_ = follows ? 0 : mount_off_ + 1;
  mount_astray_ = follows || !stands ? 0 : mount_astray_ + 1;
  if (mount_astray_ == 0) mount_rest_ = reading.mount.xyz;
  const char* const how = astray(mount_astray_, mount_off_);
  if (!how) return {};
  return {true, Fault::joint_stuck,
          fmt::format("the mount {} {:.3f} m and {:.2f} rad off its command", how, off, turned)};
}

/// The first command is of where the hand is: from elsewhere it would jump there.
ReadingCheck ReadingGate::check_start(const hand::HandReading& reading,
                                      const hand::HandCommand& command, bool commanded) const {
  if (is_blank(reading)) {  // whether a hand that is commanded stays so is checked later
    return commanded ? ReadingCheck{}
                     : ReadingCheck{false, Fault::silent, "all that the hand reads is zero"};
  }
  const double off = (command.mount.xyz - reading.mount.xyz).norm();
  const double turned = turn_off(command.mount, reading.mount);
  if (off >= options_.mount_error || turned >= options_.tracking_error) {
    return {
        true, Fault::not_at_start,
        fmt::format("the mount is {:.3f} m and {:.2f} rad off where it is to start", off, turned)};
  }
  const hand::ActuatorVector positions = hand::actuator_positions(hand_, reading.joints);
  for (int i = 0; i < hand_.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand_.actuators[static_cast<std::size_t>(i)];
    const double start =
        std::clamp(command.positions[i], actuator.command.low, actuator.command.high);
    if (std::abs(start - positions[i]) < allowed_errors_[i]) continue;
    return {true, Fault::not_at_start,
            fmt::format("{} is at {:.2f} rad, and to start at {:.2f}", actuator.name, positions[i],
                        start)};
  }
  return {};
}

}  // namespace palpate::skills
