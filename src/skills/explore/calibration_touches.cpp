// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/calibration_touches.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/random.hpp"
#include "palpate/hand/self_clearance.hpp"
#include "skills/motion/lowest_part.hpp"

namespace palpate::skills {
namespace {

constexpr int kDrawn = 3000;          // of which those count that can touch the table
constexpr int kUses = 24;             // grasps for which the hand is to be known
constexpr std::uint64_t kDesign = 1;  // seed of what is drawn: the same for every hand
constexpr double kSteepest = 1.4;     // rad of pitch; at pi/2 yaw and roll are one
constexpr double kAlone = 0.008;      // m by which all else is higher than the fingertip
constexpr double kSpread = 0.08;      // m to all sides over which the table is touched
constexpr double kTurnSpeed = 2.5, kBendSpeed = 2, kSlideSpeed = 0.5;  // rad/s, m/s, about
constexpr double kMinGain = 1e-6;                                      // s, of another order

/// Puts a finger somewhere on its way from the open to the closed hand.
void bend_finger(const hand::Description& hand, int finger, RandomStream& random,
                 hand::ActuatorVector& posture) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const hand::Range& bend = actuator.bend;
    if (actuator.finger == finger && bend.high > bend.low) {
      posture[i] = random.uniform(bend.low, bend.high);
    }
  }
}

CalibrationTouch draw_touch(const hand::Description& hand, int finger, RandomStream& random) {
  CalibrationTouch touch;
  touch.finger = finger;
  touch.posture = random.uniform() < 0.5 ? hand.postures.folded : hand.postures.stretched;
  bend_finger(hand, finger, random, touch.posture);
  touch.attitude.pitch = random.uniform(-0.3, kSteepest);
  touch.attitude.roll = random.uniform(-1.6, 1.6);
  touch.aside = {random.uniform(-kSpread, kSpread), random.uniform(-kSpread, kSpread)};
  return touch;
}

/// By how much the fingertip is lower than all else of the hand, m.
double stands_out(const hand::Description& hand, const CalibrationTouch& touch) {
  const int tip = hand.fingers[static_cast<std::size_t>(touch.finger)].link;
  const auto is_tip = [tip](int link) { return link == tip; };
  const auto is_other = [tip](int link) { return link != tip; };
  return lowest_part(hand, touch.posture, touch.attitude, is_other) -
         lowest_part(hand, touch.posture, touch.attitude, is_tip);
}

std::vector<CalibrationTouch> possible_touches(const hand::Description& hand) {
  RandomStream random(kDesign, "attitudes");
  const hand::SelfClearance clearance(hand,
                                      hand::joints_in_free_flexion(hand, hand.postures.stretched));
  std::vector<CalibrationTouch> touches;
  for (int i = 0; i < kDrawn; ++i) {
    const CalibrationTouch touch = draw_touch(hand, i % hand.finger_count(), random);
    const auto joints = hand::joints_in_free_flexion(hand, touch.posture);
    if (!clearance.is_clear(joints)) continue;
    if (stands_out(hand, touch) > kAlone) touches.push_back(touch);
  }
  return touches;
}

/// s that it takes from one to another, about.
double seconds_between(const CalibrationTouch& a, const CalibrationTouch& b) {
  const double turn = std::max(std::abs(a.attitude.pitch - b.attitude.pitch),
                               std::abs(a.attitude.roll - b.attitude.roll));
  const double bend = (a.posture - b.posture).cwiseAbs().maxCoeff();
  return std::max({turn / kTurnSpeed, bend / kBendSpeed, (a.aside - b.aside).norm() / kSlideSpeed});
}

/// The nearest one comes next.
void sort_by_nearness(std::vector<CalibrationTouch>& touches) {
  for (std::size_t i = 1; i < touches.size(); ++i) {
    const auto nearer = [&](const auto& a, const auto& b) {
      return seconds_between(touches[i - 1], a) < seconds_between(touches[i - 1], b);
    };
    const auto next = touches.begin() + static_cast<std::ptrdiff_t>(i);
    std::iter_swap(next, std::min_element(next, touches.end(), nearer));
  }
}

/// s that are saved by turning round the order from the one after `i` to `j`.
double gain(const std::vector<CalibrationTouch>& touches, std::size_t i, std::size_t j) {
  const double before = seconds_between(touches[i], touches[i + 1]);
  const double after = seconds_between(touches[i], touches[j]);
  if (j + 1 == touches.size()) return before - after;
  return before - after + seconds_between(touches[j], touches[j + 1]) -
         seconds_between(touches[i + 1], touches[j + 1]);
}

/// Turns round stretches of the order while that shortens it (2-opt). @return whether one did
bool shorten(std::vector<CalibrationTouch>& touches) {
  bool shorter = false;
  for (std::size_t i = 0; i + 2 < touches.size(); ++i) {
    for (std::size_t j = i + 2; j < touches.size(); ++j) {
      if (gain(touches, i, j) < kMinGain) continue;
      const auto begin = touches.begin();
      std::reverse(begin + static_cast<std::ptrdiff_t>(i + 1),
                   begin + static_cast<std::ptrdiff_t>(j + 1));
      shorter = true;
    }
  }
  return shorter;
}

}  // namespace

hand::MountPosition CalibrationTouch::mount(const CalibrateOptions& options, double height) const {
  return {{options.x + aside.x(), options.y + aside.y(), height},
          {0, attitude.pitch, attitude.roll}};
}

tactile::MountPrior mount_prior(const CalibrateOptions& options) {
  return {options.mount, options.mount_angle, options.table_height, options.table_tilt};
}

std::vector<tactile::TipPosture> fingertips_in_grasps(const hand::Description& hand) {
  RandomStream random(kDesign, "grasps");
  std::vector<tactile::TipPosture> tips;
  for (int i = 0; i < kUses; ++i) {
    hand::ActuatorVector posture = hand.postures.top.open;
    for (int finger = 0; finger < hand.finger_count(); ++finger) {
      bend_finger(hand, finger, random, posture);
    }
    const auto joints = hand::joints_in_free_flexion(hand, posture);
    for (int finger = 0; finger < hand.finger_count(); ++finger) tips.push_back({finger, joints});
  }
  return tips;
}

std::optional<CalibrationTouch> calibration_touch(const hand::Description& hand, int finger) {
  std::optional<CalibrationTouch> best;
  double most = 0;
  for (const CalibrationTouch& touch : possible_touches(hand)) {
    const double alone = touch.finger == finger ? stands_out(hand, touch) : 0;
    if (alone <= most) continue;
    most = alone;
    best = touch;
  }
  return best;
}

std::vector<CalibrationTouch> calibration_touches(const hand::Description& hand,
                                                  const CalibrateOptions& options) {
  const auto possible = possible_touches(hand);
  std::vector<tactile::TipOnPlane> tips;
  for (const CalibrationTouch& touch : possible) {
    tips.push_back({{touch.finger, hand::joints_in_free_flexion(hand, touch.posture)},
                    Eigen::Vector3d::Zero(),
                    touch.mount(options, 0).pose().inverse(),
                    options.sigma});
  }
  std::vector<CalibrationTouch> chosen;
  for (const std::size_t i :
       tactile::choose_touches(hand, tips, static_cast<std::size_t>(options.touches),
                               fingertips_in_grasps(hand), mount_prior(options))) {
    chosen.push_back(possible[i]);
  }
  sort_by_nearness(chosen);
  while (shorten(chosen)) {
  }
  return chosen;
}

}  // namespace palpate::skills
