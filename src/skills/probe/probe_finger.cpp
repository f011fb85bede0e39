// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/probe_finger.hpp"

#include <algorithm>
#include <span>

#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/grasping/closing_trajectory.hpp"
#include "palpate/grasping/force_distribution.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "skills/grasp/pressing.hpp"
#include "skills/motion/motion_constants.hpp"

namespace palpate::skills {

using localization::Posterior;

namespace {

constexpr std::size_t kWindow = 15;       // readings of a touch that are averaged
constexpr double kTransferSeconds = 0.4;  // s, of a finger's force to the others, and back
constexpr double kMoveSeconds = 0.3;      // s
constexpr double kReturnSeconds = 0.6;    // s, back to where the finger pressed
constexpr double kLongestClose = 1.5;     // s
constexpr double kOuterTorque = 0.7;      // of the outer joints' torque, of that of the first
constexpr double kTouchSeconds = 4;       // s that a touch takes, and back
constexpr double kLost = 0.03;            // N at which a holding finger has lost touch
constexpr int kMinHolding = 2;            // fingers that hold meanwhile, the thumb among them
constexpr int kSteps = 2;                 // of J4 and of J0 to either side
constexpr std::size_t kPoses = 6;         // by which a move is judged, the heaviest
constexpr double kSame = 0.05;            // rad, of actuators of two moves that are the same

/// Places (mount's frame) where each finger has touched the object since the hand closed.
using KnownSpots = hand::PerFinger<std::vector<Eigen::Vector3d>>;

KnownSpots known_spots(const Executor& robot) {
  KnownSpots known;
  for (const estimation::TouchEvent event :
       {estimation::TouchEvent::closed, estimation::TouchEvent::probed}) {
    for (const std::size_t reading : robot.log().all(event)) {
      for (const auto& contact : contacts_at(robot, reading)) {
        known[static_cast<std::size_t>(contact.finger)].push_back(contact.p);
      }
    }
  }
  return known;
}

/// A posture whose actuators of one finger are those of another posture.
hand::ActuatorVector with_finger(const hand::Description& hand, hand::ActuatorVector posture,
                                 int finger, const hand::ActuatorVector& other) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    if (hand.actuators[static_cast<std::size_t>(i)].finger == finger) posture[i] = other[i];
  }
  return posture;
}

/// Where closing ends at the latest: at the end of each actuator's range.
hand::ActuatorVector closing_ends(const hand::Description& hand) {
  hand::ActuatorVector ends = hand::ActuatorVector::Zero(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    ends[i] = actuator.closing < 0 ? actuator.command.low : actuator.command.high;
  }
  return ends;
}

/// Whether the thumb and a finger, other than `but_for`, touch what they held.
bool still_holds(const Executor& robot, int but_for) {
  int fingers = 0;
  for (int finger = 0; finger < robot.model().finger_count(); ++finger) {
    fingers += finger != but_for && hand::tip_force(robot.reading(), finger) > kLost;
  }
  return fingers >= kMinHolding && hand::tip_force(robot.reading(), robot.model().thumb) > kLost;
}

}  // namespace

std::vector<tactile::Contact> contacts_at(const Executor& robot, std::size_t reading) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const std::size_t count = std::min(reading + 1, kWindow);
  return tactile::contacts_with_normals(
      tactile::lasting_contacts(readings.subspan(reading + 1 - count, count), robot.model(), {}));
}

bool FingerProbes::was_made(const hand::Description& hand, const Move& move) const {
  return std::any_of(made_.begin(), made_.end(), [&](const Move& other) {
    const hand::ActuatorVector alone = with_finger(hand, other.opened, move.finger, move.opened);
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
  const int thumb = robot.model().thumb;
  for (int finger = 0; finger < robot.model().finger_count(); ++finger) {
    if (finger == thumb) continue;
    std::vector<tactile::Contact> others;
    hand::PerFinger<bool> holds{};
    for (const auto& contact : contacts) {
      if (contact.finger == finger) continue;
      others.push_back(contact);
      holds[static_cast<std::size_t>(contact.finger)] = true;
    }
    if (!holds[static_cast<std::size_t>(thumb)] ||
        std::count(holds.begin(), holds.end(), true) < kMinHolding)
      continue;
    const auto balanced = grasping::distribute_forces(others, options_.friction, press_, load);
    if (balanced.wrench_residual > options_.balance) continue;
    free.push_back({finger, pressing_command(robot, others, balanced.forces)});
  }
  return free;
}

std::vector<FingerProbes::Move> FingerProbes::moves(const Executor& robot,
                                                    const FreeFinger& free) const {
  const hand::Description& hand = robot.model();
  const auto closing = hand::closing_actuators(hand, free.finger);
  const auto spreading = hand::spreading_actuator(hand, free.finger);
  std::vector<Move> result;
  if (closing.empty()) return result;
  for (int side = -kSteps; side <= kSteps; ++side) {
    if (!spreading && side != 0) continue;
    for (int bend = -kSteps; bend <= kSteps; ++bend) {
      if (closing.size() < 2 && bend != 0) continue;
      Move move{free.finger, free.held, {}};
      const auto shift = [&](int index, double by) {
        const auto& actuator = hand.actuators[static_cast<std::size_t>(index)];
        const double way = actuator.closing < 0 ? -by : by;
        double& value = move.opened[index];
        value = std::clamp(value + way, actuator.command.low, actuator.command.high);
      };
      shift(closing[0], -options_.opening);
      if (spreading) shift(*spreading, options_.spread * side / kSteps);
      if (closing.size() > 1) shift(closing[1], options_.bend * bend / kSteps);
      result.push_back(move);
    }
  }
  return result;
}

/// Closes the moved finger virtually, for the heaviest of the poses in question.
FingerProbes::Prediction FingerProbes::predict(const Executor& robot, const Posterior& held,
                                               const Move& move,
                                               const std::vector<Eigen::Vector3d>& known) const {
  const auto finger = static_cast<std::size_t>(move.finger);
  const Eigen::Isometry3d T_world_mount = robot.reading().mount.pose();
  hand::PerFinger<bool> closing{};
  closing[finger] = true;
  const grasping::ClosingLaw law(robot.model(), kPlannedRate, closing_ends(robot.model()));
  grasping::ClosingTrajectory path =
      grasping::closing_trajectory(robot.model(), move.opened, law, closing);
  grasping::end_at_other_fingers(robot.model(), robot.reading().joints, finger, path);
  const auto& shapes = path.fingers[finger];
  Prediction prediction;
  if (shapes.size() < 2) return prediction;

  const auto& modes = held.modes;
  double looked_at = 0;
  std::size_t first_stop = 0;  // by the heaviest pose that it should meet
  for (std::size_t i = 0; i < std::min(modes.size(), kPoses); ++i) {
    looked_at += modes[i].weight;
    const grasping::PlacedObject object(object_, modes[i].T_frame_object, T_world_mount);
    const auto [stop, contact] = grasping::meet(object, path, finger, 0);
    if (stop == 0 || !contact) continue;
    if (first_stop == 0) first_stop = stop;
    const bool is_new = std::none_of(known.begin(), known.end(), [&](const Eigen::Vector3d& p) {
      return (p - contact->p).norm() < options_.elsewhere;
    });
    if (is_new) prediction.chance += modes[i].weight;
  }
  prediction.chance /= looked_at;
  const std::size_t stop = first_stop > 0 ? first_stop : shapes.size() - 1;
  const Eigen::Vector3d from = shapes.front().tip.back().cast<double>();
  const Eigen::Vector3d way = shapes[stop].tip.back().cast<double>() - from;
  prediction.probe = {T_world_mount * from, T_world_mount.linear() * way.normalized(),
                      2 * way.norm(), kTouchSeconds};
  return prediction;
}

std::optional<FingerProbes::Move> FingerProbes::choose(const Executor& robot, const Posterior& held,
                                                       RandomStream random) const {
  const KnownSpots known = known_spots(robot);
  std::vector<Move> promising;
  std::vector<localization::TouchAction> probes;
  for (const FreeFinger& free : free_fingers(robot, held)) {
    for (const Move& move : moves(robot, free)) {
      if (was_made(robot.model(), move)) continue;
      const Prediction prediction =
          predict(robot, held, move, known[static_cast<std::size_t>(free.finger)]);
      const bool moves_at_all = prediction.probe.direction.norm() > 0.5;
      if (!moves_at_all || prediction.chance < options_.likely) continue;
      promising.push_back(move);
      probes.push_back(prediction.probe);
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
  const hand::ActuatorVector without = with_finger(robot.model(), move.opened, move.finger, held);
  const int knuckle = hand::closing_actuators(robot.model(), move.finger).front();
  hand::ActuatorVector open = without;
  open[knuckle] = move.opened[knuckle];
  robot.move_fingers(without, kTransferSeconds);
  robot.move_fingers(open, kOpenSeconds);
  robot.move_fingers(move.opened, kMoveSeconds);
  const hand::Description& hand = robot.model();
  const grasping::ClosingLaw law(hand, options_.closing_rate, closing_ends(hand));
  hand::PerFinger<bool> active{};
  active[static_cast<std::size_t>(move.finger)] = true;
  hand::ActuatorVector torque =
      hand::ActuatorVector::Constant(hand.actuator_count(), kOuterTorque * options_.torque);
  torque[knuckle] = options_.torque;
  robot.set_grip(Grip{law, torque, active});
  robot.wait(kLongestClose, [&](const hand::HandReading& reading) {
    return hand::tip_force(reading, move.finger) > options_.touch_force;
  });
  robot.set_grip(std::nullopt);
  robot.wait(kWindow * hand::kTick);
  robot.add_event(estimation::TouchEvent::probed);
  hand::ActuatorVector away = robot.command().positions;
  const bool closes_up = hand.actuators[static_cast<std::size_t>(knuckle)].closing > 0;
  away[knuckle] = closes_up ? std::min(away[knuckle], move.opened[knuckle])
                            : std::max(away[knuckle], move.opened[knuckle]);
  robot.move_fingers(away, kOpenSeconds);
  robot.move_fingers(open, kMoveSeconds);
  robot.move_fingers(without, kReturnSeconds);
  robot.move_fingers(held, kTransferSeconds);
  robot.wait(kWindow * hand::kTick);
  return still_holds(robot, move.finger);
}

}  // namespace palpate::skills
