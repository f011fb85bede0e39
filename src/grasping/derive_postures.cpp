// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/derive_postures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "grasping/preshape_search.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/self_clearance.hpp"

namespace palpate::grasping {
namespace {

constexpr double kFoldedShare = 0.9;    // of the way to closed
constexpr double kBendShare = 0.75;     // of it, in grasps
constexpr double kSideways = 0.08;      // rad, of fingers that spread
constexpr double kLevel = 0.006;        // m above the lowest part that count as its level
constexpr double kProbed = 0.045;       // m around the middle of the underside, where it counts
constexpr double kForearmClear = 0.03;  // m above the underside
constexpr double kBack = 0.35;          // rad by which fingers bend back at most
constexpr double kGoodMargin = 0.05;    // m by which a pointing fingertip is lower than all else

/// All fingers so far on their way to closed, the other actuators as in the open hand.
hand::ActuatorVector all_bent(const hand::Description& hand, double share) {
  hand::ActuatorVector positions = hand.postures.top.open;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing != 0) positions[i] = bent(actuator, share);
    if (actuator.closing == 0 && actuator.finger >= 0 && actuator.finger != hand.thumb) {
      positions[i] = hand::straight_command(actuator);
    }
  }
  return positions;
}

/// Whether a link is the palm or moves with it, and does not carry it as a forearm does.
bool is_beyond_wrist(const hand::Description& hand, int link) {
  while (link >= 0 && link != hand.palm) link = hand.links[static_cast<std::size_t>(link)].parent;
  return link >= 0;
}

/// The surface of the hand in a posture, in the mount's frame.
struct Ball {
  int link;
  bool beyond_wrist;
  Eigen::Vector3d center;
  double radius;
};

std::vector<Ball> surface(const hand::Description& hand, const hand::ActuatorVector& positions) {
  const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, positions));
  std::vector<Ball> balls;
  for (const auto& sphere : hand.spheres) {
    balls.push_back({sphere.link, is_beyond_wrist(hand, sphere.link),
                     T[static_cast<std::size_t>(sphere.link)] * sphere.center, sphere.radius});
  }
  return balls;
}

/// Whether a hand can take a posture without its fingers pressing on one another or on the palm.
bool is_clear(const hand::Description& hand, const hand::ActuatorVector& positions) {
  const auto stretched = hand::joints_in_free_flexion(hand, all_bent(hand, 0));
  return hand::SelfClearance(hand, stretched)
      .is_clear(hand::joints_in_free_flexion(hand, positions));
}

/// Fingers closed as far as they can be without meeting one another or the palm.
hand::ActuatorVector folded(const hand::Description& hand) {
  for (double share = kFoldedShare; share > 0.05; share -= 0.05) {
    const auto positions = all_bent(hand, share);
    if (is_clear(hand, positions)) return positions;
  }
  return all_bent(hand, 0);
}

Eigen::Matrix3d rotation(const hand::Attitude& attitude) {
  return hand::MountPosition{Eigen::Vector3d::Zero(), {0, attitude.pitch, attitude.roll}}
      .pose()
      .linear();
}

template <class Evaluate>
void for_each_attitude(double rolls, const Evaluate& evaluate) {
  constexpr double kStep = 0.1;
  for (double pitch = -1.4; pitch <= 1.41; pitch += kStep) {
    for (double roll = -rolls; roll <= rolls + 1e-9; roll += kStep) evaluate({pitch, roll});
  }
}

/// What of the hand is within kLevel of its lowest, seen from below on a grid. A forearm is no part
/// of it, and has to be clear of it: what carries it would be in the table.
struct Underside {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double area = 0;  ///< m^2, of what lies within kProbed of the middle
};

Underside underside(const std::vector<Ball>& balls, const hand::Attitude& attitude) {
  constexpr double kCell = 0.008, kReach = 0.16;  // m
  constexpr int kCells = static_cast<int>(2 * kReach / kCell);
  const Eigen::Matrix3d R = rotation(attitude);
  Eigen::MatrixXd bottom = Eigen::MatrixXd::Constant(kCells, kCells, 1.0);
  double forearm = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls) {
    const Eigen::Vector3d p = R * ball.center;
    if (!ball.beyond_wrist) {
      forearm = std::min(forearm, p.z() - ball.radius);
      continue;
    }
    const int reach = static_cast<int>(std::ceil(ball.radius / kCell));
    const int cx = static_cast<int>((p.x() + kReach) / kCell);
    const int cy = static_cast<int>((p.y() + kReach) / kCell);
    for (int x = std::max(0, cx - reach); x <= std::min(kCells - 1, cx + reach); ++x) {
      for (int y = std::max(0, cy - reach); y <= std::min(kCells - 1, cy + reach); ++y) {
        const Eigen::Vector2d cell((x + 0.5) * kCell - kReach, (y + 0.5) * kCell - kReach);
        const double aside = (cell - p.head<2>()).squaredNorm();
        const double inside = ball.radius * ball.radius - aside;
        if (inside < 0) continue;
        bottom(x, y) = std::min(bottom(x, y), p.z() - std::sqrt(inside));
      }
    }
  }
  const double low = bottom.minCoeff();
  if (forearm < low + kForearmClear) return {};
  std::vector<Eigen::Vector2d> level;
  for (int x = 0; x < kCells; ++x) {
    for (int y = 0; y < kCells; ++y) {
      if (bottom(x, y) > low + kLevel) continue;
      level.emplace_back((x + 0.5) * kCell - kReach, (y + 0.5) * kCell - kReach);
    }
  }
  Underside side;
  for (const auto& p : level) side.center += p / static_cast<double>(level.size());
  const auto near = std::count_if(level.begin(), level.end(), [&](const Eigen::Vector2d& p) {
    return (p - side.center).norm() < kProbed;
  });
  side.area = kCell * kCell * static_cast<double>(near);
  return side;
}

/// The fingers straight or bent back, the thumb's first joints anywhere.
std::vector<hand::ActuatorVector> flat_postures(const hand::Description& hand) {
  constexpr int kTries = 12;
  RandomStream random(1, "flat");
  std::vector<hand::ActuatorVector> postures;
  for (int i = 0; i < kTries; ++i) {
    hand::ActuatorVector positions = all_bent(hand, 0);
    const double back = i % 3 == 0 ? 0 : random.uniform(0, 1);
    for (int k = 0; k < hand.actuator_count(); ++k) {
      const auto& actuator = hand.actuators[static_cast<std::size_t>(k)];
      const auto& [low, high] = actuator.command;
      const double end = actuator.closing > 0 ? low : high;  // away from closed
      if (actuator.finger == hand.thumb && i > 0) {
        positions[k] =
            actuator.closing != 0 ? hand::straight_command(actuator) : random.uniform(low, high);
      } else if (actuator.closing != 0) {
        positions[k] += std::clamp(back * (end - positions[k]), -kBack, kBack);
      }
    }
    if (is_clear(hand, positions)) postures.push_back(positions);
  }
  return postures;
}

hand::FlatHand find_flat(const hand::Description& hand) {
  hand::FlatHand best{all_bent(hand, 0), hand.postures.top.attitudes.front(), {0, 0}};
  double largest = 0;
  for (const auto& positions : flat_postures(hand)) {
    const auto balls = surface(hand, positions);
    for_each_attitude(0.6, [&](const hand::Attitude& attitude) {
      const Underside side = underside(balls, attitude);
      if (side.area <= largest) return;
      largest = side.area;
      best = {positions, attitude, side.center};
    });
  }
  return best;
}

/// By how much a finger's tip is lower than all else of the hand, m.
double margin(const hand::Description& hand, const std::vector<Ball>& balls, int finger,
              const hand::Attitude& attitude) {
  const Eigen::RowVector3d down = rotation(attitude).row(2);
  double tip = std::numeric_limits<double>::infinity(), others = tip;
  for (const Ball& ball : balls) {
    const double low = down.dot(ball.center) - ball.radius;
    const bool own = ball.link == hand.fingers[static_cast<std::size_t>(finger)].link;
    (own ? tip : others) = std::min(own ? tip : others, low);
  }
  return others - tip;
}

struct Pointing {
  hand::PointingHand hand;
  double margin = -std::numeric_limits<double>::infinity();
};

Pointing find_pointing(const hand::Description& hand, int finger) {
  Pointing best;
  for (const auto& others : {folded(hand), all_bent(hand, 0.4)}) {
    for (const double own : {0.0, 0.15, 0.3}) {
      hand::ActuatorVector positions = others;
      const auto straight = all_bent(hand, own);
      for (int i = 0; i < hand.actuator_count(); ++i) {
        if (hand.actuators[static_cast<std::size_t>(i)].finger == finger)
          positions[i] = straight[i];
      }
      if (!is_clear(hand, positions)) continue;
      const auto balls = surface(hand, positions);
      for_each_attitude(0.8, [&](const hand::Attitude& attitude) {
        const double lower = margin(hand, balls, finger, attitude);
        if (lower <= best.margin) return;
        best = {{finger, positions, attitude}, lower};
      });
    }
  }
  return best;
}

std::vector<hand::PointingHand> find_all_pointing(const hand::Description& hand) {
  std::vector<Pointing> found;
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    if (finger != hand.thumb) found.push_back(find_pointing(hand, finger));
  }
  std::stable_sort(found.begin(), found.end(), [](const Pointing& a, const Pointing& b) {
    return std::min(a.margin, kGoodMargin) > std::min(b.margin, kGoodMargin);
  });
  std::vector<hand::PointingHand> pointing;
  for (const Pointing& one : found) {
    if (std::isfinite(one.margin)) pointing.push_back(one.hand);
  }
  if (pointing.empty()) throw BadInput("no finger of the hand can point without meeting another");
  return pointing;
}

void set_bends(hand::Description& hand) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const auto& [low, high] = actuator.command;
    if (actuator.finger < 0) continue;
    const double a =
        actuator.closing != 0 ? hand::straight_command(actuator) : hand.postures.top.open[i];
    const double b = actuator.closing != 0 ? bent(actuator, kBendShare) : a;
    const double margin = actuator.closing != 0 ? 0 : kSideways;
    actuator.bend = {std::max(low, std::min(a, b) - margin),
                     std::min(high, std::max(a, b) + margin)};
  }
}

/// Where closing actuators stop when the hand lets go; nothing keeps the others.
hand::ActuatorVector released(const hand::Description& hand) {
  hand::ActuatorVector result = hand.postures.top.open;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing == 0) result[i] = actuator.command.high;
  }
  return result;
}

}  // namespace

void derive_postures(hand::Description& hand, const ProgressCallback& progress) {
  hand.postures.top = find_preshape(hand, progress);
  hand.postures.flat = find_flat(hand);
  hand.postures.pointing = find_all_pointing(hand);
  hand.postures.stretched = all_bent(hand, 0);
  hand.postures.folded = folded(hand);
  hand.postures.released = released(hand);
  set_bends(hand);
}

}  // namespace palpate::grasping
