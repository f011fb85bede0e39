// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/probe_finger.hpp"

#include <algorithm>
#include <span>

#include "estimation/mean_load.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/grasping/closing_trajectory.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "skills/grasp/pressing.hpp"
#include "skills/motion_constants.hpp"

namespace palpate::skills {

using localization::Posterior;

namespace {

constexpr std::size_t kWindow = 15;       // readings of a touch that are averaged
constexpr double kTransferSeconds = 0.4;  // s, of a finger's force to the others, and back
constexpr double kMoveSeconds = 0.3;      // s
constexpr double kReturnSeconds = 0.6;    // s, back to where the finger pressed
constexpr double kLongestClose = 1.5;     // s
constexpr double kThumbLimit = 1.0;       // rad; the thumb does not move here
constexpr double kTouchSeconds = 4;       // s that a touch takes, and back
constexpr double kLost = 0.03;            // N at which a holding finger has lost touch
constexpr int kMinHolding = 2;            // fingers that hold meanwhile, the thumb among them
constexpr int kSteps = 2;                 // of J4 and of J0 to either side
constexpr std::size_t kPoses = 6;         // by which a move is judged, the heaviest
constexpr double kSame = 0.05;            // rad, of actuators of two moves that are the same

int actuator(int finger, std::string_view joint) {
  return hand::actuator_index(
      std::string(hand::kFingerNames[static_cast<std::size_t>(finger)]).append(joint));
}

/// Places (base's frame) where each finger has touched the object since the hand closed.
using KnownSpots = std::array<std::vector<Eigen::Vector3d>, hand::kFingers>;

KnownSpots known_spots(const Executor& robot) {
  KnownSpots known;
  for (const estimation::TouchEvent mark :
       {estimation::TouchEvent::closed, estimation::TouchEvent::probed}) {
    for (const std::size_t reading : robot.log().all(mark)) {
      for (const auto& contact : contacts_at(robot, reading)) {
        known[static_cast<std::size_t>(contact.finger)].push_back(contact.p);
      }
    }
  }
  return known;
}

/// A posture whose actuators of one finger are those of another posture.
hand::ActuatorVector with_finger(hand::ActuatorVector posture, int finger,
                                 const hand::ActuatorVector& other) {
  for (int i = 0; i < hand::kActuators; ++i) {
    if (hand::finger_of_actuator(i) == finger) posture[i] = other[i];
  }
  return posture;
}

/// Whether the thumb and a finger, other than `but_for`, touch what they held.
bool still_holds(const Executor& robot, int but_for) {
  int fingers = 0;
  for (int finger = 1; finger < hand::kFingers; ++finger) {
    fingers += finger != but_for && hand::tip_force(robot.reading(), finger) > kLost;
  }
  return fingers + 1 >= kMinHolding && hand::tip_force(robot.reading(), 0) > kLost;
}

}  // namespace

std::vector<tactile::Contact> contacts_at(const Executor& robot, std::size_t reading) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const std::size_t count = std::min(reading + 1, kWindow);
  return tactile::lasting_contacts(readings.subspan(reading + 1 - count, count), robot.model(), {});
}

bool FingerProbes::was_made(const Move& move) const {
  return std::any_of(made_.begin(), made_.end(), [&](const Move& other) {
    const hand::ActuatorVector alone = with_finger(other.opened, move.finger, move.opened);
    return move.finger == other.finger && (alone - other.opened).cwiseAbs().maxCoeff() < kSame;
  });
}

/// Fingers whose place can be given up: the others' forces balance and bear the weight.
std::vector<FingerProbes::FreeFinger> FingerProbes::free_fingers(const Executor& robot,
                                                                 const Posterior& held) const {
  const auto contacts = contacts_at(robot, robot.log().readings.size() - 1);
  const grasping::Load load =
      weight_at(robot, held.modes.front().T_frame_object, object_.object().mass * kGravity);
  std::vector<FreeFinger> free;
  for (int finger = 1; finger < hand::kFingers; ++finger) {  // never the thumb
    std::vector<tactile::Contact> others;
    std::array<bool, hand::kFingers> holds{};
    for (const auto& contact : contacts) {
      if (contact.finger == finger) continue;
      others.push_back(contact);
      holds[static_cast<std::size_t>(contact.finger)] = true;
    }
    if (!holds[0] || std::count(holds.begin(), holds.end(), true) < kMinHolding) continue;
    const auto balanced = grasping::distribute_forces(others, options_.friction, press_, load);
    if (balanced.wrench_residual > options_.balance) continue;
    free.push_back({finger, pressing_command(robot, others, balanced.forces)});
  }
  return free;
}

std::vector<FingerProbes::Move> FingerProbes::moves(const Executor& robot,
                                                    const FreeFinger& free) const {
  std::vector<Move> result;
  for (int side = -kSteps; side <= kSteps; ++side) {
    for (int bend = -kSteps; bend <= kSteps; ++bend) {
      Move move{free.finger, free.held, {}};
      const auto shift = [&](std::string_view joint, double by) {
        const auto index = static_cast<std::size_t>(actuator(free.finger, joint));
        const auto& range = robot.actuators()[index].command;
        double& value = move.opened[static_cast<Eigen::Index>(index)];
        value = std::clamp(value + by, range.low, range.high);
      };
      shift("J3", -options_.opening);
      shift("J4", options_.spread * side / kSteps);
      shift("J0", options_.bend * bend / kSteps);
      result.push_back(move);
    }
  }
  return result;
}

/// Closes the moved finger virtually, for the heaviest of the poses in question.
FingerProbes::Foresight FingerProbes::foresee(const Executor& robot, const Posterior& held,
                                              const Move& move,
                                              const std::vector<Eigen::Vector3d>& known) const {
  const auto finger = static_cast<std::size_t>(move.finger);
  const Eigen::Isometry3d T_world_base = robot.reading().base.pose();
  std::array<bool, hand::kFingers> closing{};
  closing[finger] = true;
  const grasping::ClosingLaw law(robot.actuators(), kPlannedRate, kThumbLimit);
  grasping::ClosingTrajectory path =
      grasping::closing_trajectory(robot.model(), move.opened, law, closing);
  grasping::end_at_other_fingers(robot.model(), robot.reading().joints, finger, path);
  const auto& shapes = path.fingers[finger];
  Foresight foresight;
  if (shapes.size() < 2) return foresight;

  const auto& modes = held.modes;
  double looked_at = 0;
  std::size_t first_stop = 0;  // by the heaviest pose that it should meet
  for (std::size_t i = 0; i < std::min(modes.size(), kPoses); ++i) {
    looked_at += modes[i].weight;
    const grasping::PlacedObject object(object_, modes[i].T_frame_object, T_world_base);
    const auto [stop, contact] = grasping::meet(object, path, finger, 0);
    if (stop == 0 || !contact) continue;
    if (first_stop == 0) first_stop = stop;
    const bool is_new = std::none_of(known.begin(), known.end(), [&](const Eigen::Vector3d& p) {
      return (p - contact->p).norm() < options_.elsewhere;
    });
    if (is_new) foresight.chance += modes[i].weight;
  }
  foresight.chance /= looked_at;
  const std::size_t stop = first_stop > 0 ? first_stop : shapes.size() - 1;
  const Eigen::Vector3d from = shapes.front().tip.back().cast<double>();
  const Eigen::Vector3d way = shapes[stop].tip.back().cast<double>() - from;
  foresight.probe = {T_world_base * from, T_world_base.linear() * way.normalized(), 2 * way.norm(),
                     kTouchSeconds};
  return foresight;
}

std::optional<FingerProbes::Move> FingerProbes::choose(const Executor& robot, const Posterior& held,
                                                       RandomStream random) const {
  const KnownSpots known = known_spots(robot);
  std::vector<Move> promising;
  std::vector<localization::TouchAction> probes;
  for (const FreeFinger& free : free_fingers(robot, held)) {
    for (const Move& move : moves(robot, free)) {
      if (was_made(move)) continue;
      const Foresight foresight =
          foresee(robot, held, move, known[static_cast<std::size_t>(free.finger)]);
      const bool moves_at_all = foresight.probe.direction.norm() > 0.5;
      if (!moves_at_all || foresight.chance < options_.likely) continue;
      promising.push_back(move);
      probes.push_back(foresight.probe);
    }
  }
  if (probes.empty()) return std::nullopt;
  const auto choice = localization::choose_touch(object_, held, probes, random);
  Move best = promising[choice.index];
  best.expected_gain = {choice.information, probes[choice.index].seconds};
  return best;
}

bool FingerProbes::make(Executor& robot, const Move& move) {
  made_.push_back(move);
  const hand::ActuatorVector held = robot.command().positions;
  const hand::ActuatorVector without = with_finger(move.opened, move.finger, held);
  const int knuckle = actuator(move.finger, "J3");
  hand::ActuatorVector open = without;
  open[knuckle] = move.opened[knuckle];
  robot.move_fingers(without, kTransferSeconds);
  robot.move_fingers(open, kOpenSeconds);
  robot.move_fingers(move.opened, kMoveSeconds);
  const grasping::ClosingLaw law(robot.actuators(), options_.closing_rate, kThumbLimit);
  std::array<bool, hand::kFingers> active{};
  active[static_cast<std::size_t>(move.finger)] = true;
  robot.set_grip(Grip{law, {options_.torque, 0.7 * options_.torque}, active});
  robot.wait(kLongestClose, [&](const hand::HandReading& reading) {
    return hand::tip_force(reading, move.finger) > options_.touch_force;
  });
  robot.set_grip(std::nullopt);
  robot.wait(kWindow * hand::kTick);
  robot.mark(estimation::TouchEvent::probed);
  hand::ActuatorVector away = robot.command().positions;
  away[knuckle] = std::min(away[knuckle], move.opened[knuckle]);
  robot.move_fingers(away, kOpenSeconds);
  robot.move_fingers(open, kMoveSeconds);
  robot.move_fingers(without, kReturnSeconds);
  robot.move_fingers(held, kTransferSeconds);
  robot.wait(kWindow * hand::kTick);
  return still_holds(robot, move.finger);
}

}  // namespace palpate::skills
