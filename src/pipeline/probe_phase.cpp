// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/probe_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "palpate/hand/closing.hpp"
#include "palpate/localization/next_touch.hpp"
#include "palpate/pipeline/squeeze.hpp"
#include "palpate/touch/contact_window.hpp"

namespace palpate::pipeline {
namespace {

constexpr std::size_t kWindow = 15;     // readings of a touch that are averaged
constexpr double kOpenSeconds = 0.4;    // s
constexpr double kMoveSeconds = 0.3;    // s
constexpr double kReturnSeconds = 0.6;  // s, back to where the finger pressed
constexpr double kLongestClose = 1.5;   // s
constexpr double kThumbLimit = 1.0;     // rad; the thumb does not move here
constexpr double kTouchSeconds = 6;     // s that a touch takes at most, and back
constexpr double kLost = 0.03;          // N at which a holding finger has lost touch
constexpr int kLeastHolding = 3;        // fingers that hold meanwhile, the thumb among them
constexpr double kSame = 0.05;          // rad, of actuators of two moves that are the same

int actuator(int finger, std::string_view joint) {
  return hand::actuator_index(
      std::string(hand::kFingerNames[static_cast<std::size_t>(finger)]).append(joint));
}

std::vector<touch::Contact> contacts_now(const Robot& robot) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  return touch::lasting_contacts(readings.last(std::min(readings.size(), kWindow)), robot.model(),
                                 {});
}

/// Centre of a fingertip in the base's frame when the actuators differ from now by `change`.
Eigen::Vector3d tip_after(const Robot& robot, int finger, double j4, double j3, double j0) {
  hand::JointVector joints = robot.reading().joints;
  const std::string name(hand::kFingerNames[static_cast<std::size_t>(finger)]);
  joints[hand::joint_index(name + "J4")] += j4;
  joints[hand::joint_index(name + "J3")] += j3;
  joints[hand::joint_index(name + "J2")] += 0.5 * j0;
  joints[hand::joint_index(name + "J1")] += 0.5 * j0;
  const auto T = hand::forward_kinematics(robot.model(), joints);
  const auto index = static_cast<std::size_t>(finger);
  return T[static_cast<std::size_t>(robot.model().distal[index])] * robot.model().tips[index].b;
}

bool same(const FingerMove& a, const FingerMove& b) {
  return a.finger == b.finger && (a.opened - b.opened).cwiseAbs().maxCoeff() < kSame;
}

}  // namespace

/// Fingers whose place can be given up: the others' forces balance and bear the weight.
std::vector<int> ProbePhase::free_fingers(const Robot& robot) const {
  const auto contacts = contacts_now(robot);
  const Eigen::Vector3d down =
      robot.reading().base.pose().linear().transpose() * -Eigen::Vector3d::UnitZ();
  std::vector<int> free;
  for (int finger = 1; finger < hand::kFingers; ++finger) {  // never the thumb
    std::vector<touch::Contact> others;
    std::array<bool, hand::kFingers> holds{};
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto& contact : contacts) {
      if (contact.finger == finger) continue;
      others.push_back(contact);
      middle += contact.p;
      holds[static_cast<std::size_t>(contact.finger)] = true;
    }
    if (!holds[0] || std::count(holds.begin(), holds.end(), true) < kLeastHolding) continue;
    const Load load{middle / static_cast<double>(others.size()), weight_ * down};
    const auto balanced = balance_forces(others, options_.friction, options_.press, load);
    if (balanced.imbalance < options_.balance) free.push_back(finger);
  }
  return free;
}

std::vector<FingerMove> ProbePhase::moves(const Robot& robot, int finger) const {
  std::vector<FingerMove> result;
  for (const double j4 : {-options_.spread, 0.0, options_.spread}) {
    for (const double j0 : {-options_.bend, 0.0, options_.bend}) {
      if (j4 == 0 && j0 == 0) continue;
      FingerMove move{finger, robot.command().positions};
      const auto shift = [&](std::string_view joint, double by) {
        const auto index = static_cast<std::size_t>(actuator(finger, joint));
        const auto& range = robot.actuators()[index].command;
        double& value = move.opened[static_cast<Eigen::Index>(index)];
        value = std::clamp(value + by, range.low, range.high);
      };
      shift("J3", -options_.opening);
      shift("J4", j4);
      shift("J0", j0);
      result.push_back(move);
    }
  }
  return result;
}

std::optional<FingerMove> ProbePhase::choose(const Robot& robot, const PickState& state,
                                             const std::vector<FingerMove>& made) const {
  const Eigen::Isometry3d T_world_base = robot.reading().base.pose();
  std::vector<FingerMove> reachable;
  std::vector<localization::Probe> probes;
  for (const int finger : free_fingers(robot)) {
    for (const FingerMove& move : moves(robot, finger)) {
      const auto made_before = [&](const FingerMove& other) { return same(move, other); };
      if (std::any_of(made.begin(), made.end(), made_before)) continue;
      const auto change = [&](std::string_view joint) {
        const int index = actuator(finger, joint);
        return move.opened[index] - robot.command().positions[index];
      };
      const double j4 = change("J4"), j3 = change("J3"), j0 = change("J0");
      const Eigen::Vector3d from = tip_after(robot, finger, j4, j3, j0);
      const Eigen::Vector3d way = tip_after(robot, finger, j4, 0, j0) - from;
      reachable.push_back(move);
      probes.push_back({T_world_base * from, T_world_base.linear() * way.normalized(),
                        2 * way.norm(), kTouchSeconds});
    }
  }
  if (probes.empty()) return std::nullopt;
  const auto choice = localization::choose_probe(object_, state.estimate.posterior, probes,
                                                 RandomStream(seed_, "probe"));
  if (choice.information < options_.least_information) return std::nullopt;
  return reachable[choice.index];
}

/// Opens the finger, moves it, closes it until it touches or has closed in vain, and brings it
/// back.
/// @return whether the other fingers still hold the object
bool ProbePhase::touch(Robot& robot, const FingerMove& move) const {
  const hand::ActuatorVector held = robot.command().positions;
  hand::ActuatorVector open = held;
  const int knuckle = actuator(move.finger, "J3");
  open[knuckle] = move.opened[knuckle];
  robot.move_fingers(open, kOpenSeconds);
  robot.move_fingers(move.opened, kMoveSeconds);
  const hand::ClosingLaw law(robot.actuators(), options_.closing_rate, kThumbLimit);
  std::array<bool, hand::kFingers> active{};
  active[static_cast<std::size_t>(move.finger)] = true;
  robot.set_grip(Grip{law, {options_.torque, 0.7 * options_.torque}, active});
  robot.wait(kLongestClose, [&](const hand::HandReading& reading) {
    return tip_force(reading, move.finger) > options_.touch_force;
  });
  robot.set_grip(std::nullopt);
  robot.wait(kWindow * hand::kTick);
  robot.mark(Mark::probed);
  hand::ActuatorVector away = robot.command().positions;
  away[knuckle] = std::min(away[knuckle], move.opened[knuckle]);
  robot.move_fingers(away, kOpenSeconds);
  robot.move_fingers(open, kMoveSeconds);
  robot.move_fingers(held, kReturnSeconds);
  robot.wait(kWindow * hand::kTick);
  int holding = 0;
  for (int finger = 0; finger < hand::kFingers; ++finger) {
    holding += tip_force(robot.reading(), finger) > kLost;
  }
  return holding >= kLeastHolding;
}

PhaseEnd ProbePhase::run(Robot& robot, PickState& state) {
  std::vector<FingerMove> made;
  const auto weight = [&] {
    const auto& modes = state.estimate.posterior.modes;
    return modes.empty() ? 0.0 : modes[0].weight;
  };
  const double before = weight();
  bool holds = true;
  const double last_start = robot.time() + time_limit() - kTouchSeconds;
  while (holds && static_cast<int>(made.size()) < options_.most && weight() > 0 &&
         weight() < options_.certain && robot.time() < last_start) {
    const auto move = choose(robot, state, made);
    if (!move) break;
    holds = touch(robot, *move);
    made.push_back(*move);
    robot.mark(Mark::closed);
    state.estimate = locate(object_, robot.model(), robot.log(), locate_, seed_, Mark::closed);
  }
  return {holds, fmt::format("{} touch{}, certainty {:.2f} -> {:.2f}", made.size(),
                             made.size() == 1 ? "" : "es", before, weight())};
}

}  // namespace palpate::pipeline
