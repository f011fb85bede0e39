// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/probe_roll.hpp"

#include <algorithm>
#include <array>

#include "palpate/localization/consensus.hpp"
#include "palpate/skills/reorient/in_hand_reorientation.hpp"
#include "skills/probe/probe_finger.hpp"

namespace palpate::skills {
namespace {

constexpr double kTurn = 0.17;             // rad: as far as fingers turn an object surely
constexpr double kSeconds = 8;             // of the robot's time, there and back
constexpr double kLongest = 4;             // s of either way
constexpr double kSameSpot = 0.006;        // m
constexpr double kRelaxing = 0.8;          // s, back to the grip before
constexpr double kContactSeconds = 0.2;    // s, of contacts that are averaged, amply
constexpr std::ptrdiff_t kMinFingers = 4;  // that touch, the thumb among them

using localization::PredictedTouches;

/// How far from the object's surface each fingertip is that has rolled, and the normal there.
PredictedTouches feel_after(const geometry::ObjectModel& object,
                            const Eigen::Isometry3d& T_base_object,
                            const std::vector<tactile::Contact>& contacts, const Executor& robot,
                            const Eigen::Vector3d& turn) {
  PredictedTouches feel;
  for (const auto& contact : contacts) {
    const double radius =
        robot.model().fingers[static_cast<std::size_t>(contact.finger)].tip.radius;
    // Seen from the object, the tip's centre goes round the contact the other way.
    const Eigen::Vector3d center = contact.p + radius * (contact.n - turn.cross(contact.n));
    const auto sample = object.field().at((T_base_object.inverse() * center).cast<float>());
    localization::PredictedTouch touch;
    if (sample) {
      touch.hit = true;
      touch.distance = static_cast<double>(sample->distance);
      touch.normal = T_base_object.linear() * sample->gradient.cast<double>().normalized();
    }
    feel.push_back(touch);
  }
  return feel;
}

bool firmly_held(const hand::Description& hand, const std::vector<tactile::Contact>& contacts) {
  hand::PerFinger<bool> touches{};
  for (const auto& contact : contacts) touches[static_cast<std::size_t>(contact.finger)] = true;
  return touches[static_cast<std::size_t>(hand.thumb)] &&
         std::count(touches.begin(), touches.end(), true) >= kMinFingers;
}

/// Whether all of the contacts but one at most are still there.
bool touch_alike(const std::vector<tactile::Contact>& before,
                 const std::vector<tactile::Contact>& after) {
  const auto gone = std::count_if(before.begin(), before.end(), [&](const tactile::Contact& old) {
    return std::none_of(after.begin(), after.end(), [&](const tactile::Contact& contact) {
      return contact.finger == old.finger && (contact.p - old.p).norm() < kSameSpot;
    });
  });
  return gone <= 1;
}

/// The pose turned about its own origin, the centroid.
Eigen::Isometry3d turned(const Executor& robot, Eigen::Isometry3d T_world_object,
                         const Eigen::Vector3d& turn) {
  const Eigen::Matrix3d R_world_base = robot.reading().base.pose().linear();
  T_world_object.linear() = R_world_base * Eigen::AngleAxisd(turn.norm(), turn.normalized()) *
                            R_world_base.transpose() * T_world_object.linear();
  return T_world_object;
}

}  // namespace

std::optional<Roll> most_informative_roll(const Executor& robot,
                                          const geometry::ObjectModel& object,
                                          const localization::Posterior& held,
                                          const std::vector<tactile::Contact>& contacts) {
  if (held.modes.empty() || !firmly_held(robot.model(), contacts)) return std::nullopt;
  const Eigen::Isometry3d T_base_world = robot.reading().base.pose().inverse();
  const auto poses = localization::poses_of(held);
  std::vector<double> weights;
  for (const localization::WeightedPose& pose : poses) weights.push_back(pose.weight);
  const auto information_of = [&](const Eigen::Vector3d& turn) {
    std::vector<PredictedTouches> feels;
    for (const localization::WeightedPose& pose : poses) {
      feels.push_back(feel_after(object, T_base_world * pose.T, contacts, robot, turn));
    }
    return localization::information_bound(feels, weights, touches_of_modes());
  };
  const double already =
      information_of(Eigen::Vector3d::Zero());  // poses that do not fit what is felt
  std::optional<Roll> best;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d turn = sign * kTurn * Eigen::Vector3d::Unit(axis);
      const ExpectedGain expected_gain{std::max(0.0, information_of(turn) - already), kSeconds};
      if (!best || expected_gain.information > best->expected_gain.information)
        best = Roll{turn, expected_gain};
    }
  }
  return best;
}

bool roll(Executor& robot, const geometry::ObjectModel& object, const localization::Posterior& held,
          const Roll& roll, const tactile::ContactErrorModel& errors, std::uint64_t seed) {
  ReorientOptions options;
  options.sampling.samples = 0;  // the poses in question disagree on what a rollout would show
  options.errors = errors;
  options.longest = kLongest;
  const hand::ActuatorVector before = robot.command().positions;
  const auto contacts = contacts_at(robot, robot.log().readings.size() - 1);
  const Eigen::Isometry3d& start = held.modes.front().T_frame_object;
  const auto aside =
      reorient_in_hand(robot, object, held, turned(robot, start, roll.turn), options, seed);
  if (aside.end == ReorientEnd::losing) return false;
  robot.wait(kContactSeconds);
  robot.mark(estimation::TouchEvent::rolled);
  const auto back = reorient_in_hand(robot, object, aside.posterior, start, options, seed);
  robot.move_fingers(before, kRelaxing);
  robot.wait(kContactSeconds);
  return back.end != ReorientEnd::losing &&
         touch_alike(contacts, contacts_at(robot, robot.log().readings.size() - 1));
}

}  // namespace palpate::skills
