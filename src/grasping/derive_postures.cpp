// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/derive_postures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <sstream>
#include <string>

#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/self_distance.hpp"

namespace palpate::grasping {
namespace {

constexpr double kTouch = 1.2;        // N, of a fingertip that closes
constexpr double kPress = 6.0;        // N, of all fingertips, in the search
constexpr double kFoldedShare = 0.9;  // of the way to closed
constexpr double kBendShare = 0.75;   // of it, in grasps
constexpr double kSideways = 0.08;    // rad, of fingers that spread
constexpr int kSamples = 160;         // of preshapes, at random
constexpr int kSteps = 120;           // of the best one, at random
constexpr double kNoGrasp = 2.0;      // cost of an object that cannot be grasped
constexpr double kMissing = 0.25;     // cost of a finger whose tip does not meet the object
constexpr double kAlike = 0.7;        // cosine between axes of joints that close a finger
constexpr double kFullWay = 2.0;      // rad that an actuator of speed 1 closes in the time of all
constexpr double kSteepest = 1.45;    // rad of pitch; at pi/2 yaw and roll are one
constexpr double kLevel = 0.006;      // m above the lowest part that count as its level
constexpr double kProbed = 0.045;     // m around the middle of the underside, where it counts
constexpr double kBack = 0.35;        // rad by which fingers bend back at most
constexpr double kGoodMargin = 0.05;  // m by which a pointing fingertip is lower than all else

double start_of(const hand::Actuator& actuator) {
  return std::clamp(0.0, actuator.command.low, actuator.command.high);
}

double end_of(const hand::Actuator& actuator) {
  return actuator.closing > 0 ? actuator.command.high : actuator.command.low;
}

/// A closing actuator so far on its way from straight to closed.
double bent(const hand::Actuator& actuator, double share) {
  return start_of(actuator) + share * (end_of(actuator) - start_of(actuator));
}

/// What is searched for.
struct HandPosture {
  /// Shares of the way to closed at which fingers and thumb are open: first joints, outer joints.
  std::array<double, 2> fingers{}, thumb{};
  double curl = 1;  ///< speed of the outer joints, relative to their ranges
  hand::ActuatorVector
      opposition;  ///< shares of their ranges at which the thumb's first joints stand
  hand::Attitude attitude;
  double cost = std::numeric_limits<double>::infinity();
};

/// Whether a closing actuator is not its finger's first.
bool is_outer(const hand::Description& hand, int actuator) {
  const int finger = hand.actuators[static_cast<std::size_t>(actuator)].finger;
  return hand::closing_actuators(hand, finger).front() != actuator;
}

hand::ActuatorVector open_hand(const hand::Description& hand, const HandPosture& posture) {
  hand::ActuatorVector open(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const auto& [low, high] = actuator.command;
    const bool thumb = actuator.finger == hand.thumb;
    if (actuator.closing != 0) {
      open[i] = bent(actuator, (thumb ? posture.thumb : posture.fingers)[is_outer(hand, i)]);
    } else {
      open[i] = thumb ? low + posture.opposition[i] * (high - low) : std::clamp(0.0, low, high);
    }
  }
  return open;
}

/// The hand with the speeds at which its actuators close from a posture: all first joints would be
/// closed at the same time, and, at a curl of 1, the outer ones, too.
hand::Description closing_hand(hand::Description hand, const HandPosture& posture) {
  const auto open = open_hand(hand, posture);
  std::vector<bool> outer;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    outer.push_back(hand.actuators[static_cast<std::size_t>(i)].closing != 0 && is_outer(hand, i));
  }
  for (int i = 0; i < hand.actuator_count(); ++i) {
    auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing == 0) continue;
    const double way = std::max(0.2, std::abs(end_of(actuator) - open[i]));
    const double speed = way * (outer[static_cast<std::size_t>(i)] ? posture.curl : 1) / kFullWay;
    actuator.closing = std::copysign(speed, actuator.closing);
  }
  return hand;
}

hand::ActuatorVector closed_ends(const hand::Description& hand, const hand::ActuatorVector& open) {
  hand::ActuatorVector ends = open;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing != 0) ends[i] = end_of(actuator);
  }
  return ends;
}

/// A cylinder about the z axis, centred at the origin.
geometry::TriangleMesh cylinder(double radius, double height) {
  constexpr int kSides = 24;
  geometry::TriangleMesh mesh;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    for (const double z : {-0.5 * height, 0.5 * height}) {
      mesh.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  }
  for (int i = 0; i < kSides; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % kSides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    if (i < 2) continue;
    mesh.triangles.push_back({0, 2 * i, 2 * (i - 1)});
    mesh.triangles.push_back({1, 2 * (i - 1) + 1, 2 * i + 1});
  }
  return mesh;
}

/// Objects of household size, each in a pose on the table.
class Trials {
 public:
  Trials() {
    add("cylinder", cylinder(0.030, 0.11), {0, 0, 0.055});
    add("can", cylinder(0.040, 0.09), {0, 0, 0.045});
    add("box", geometry::box_mesh({0.05, 0.05, 0.09}), {0, 0, 0.045});
    add("flat box", geometry::box_mesh({0.11, 0.05, 0.05}), {0, 0, 0.025});
  }

  double cost(const hand::Description& given, const HandPosture& tried) const {
    const hand::Description hand = closing_hand(given, tried);
    const auto open = open_hand(hand, tried);
    const ClosingLaw law(hand, 1.0, closed_ends(hand, open));
    const auto path = closing_trajectory(hand, open, law);
    double sum = 0;
    for (const auto& [object, T_world_object] : objects_) {
      PlanOptions options;
      options.press = kPress;
      options.missing_finger = kMissing;
      options.yaws = 8;
      options.places = 1;
      options.spacing = 0.015;
      double best = kNoGrasp;
      for (const auto& grasp : find_grasps(object, T_world_object, path, tried.attitude, options)) {
        best = std::min(best, grasp.cost);
      }
      sum += best;
    }
    return sum;
  }

 private:
  void add(const char* name, const geometry::TriangleMesh& mesh, const Eigen::Vector3d& place) {
    constexpr double kMass = 0.2;  // kg
    objects_.emplace_back(geometry::ObjectModel(geometry::make_known_object(name, mesh, kMass)),
                          Eigen::Isometry3d(Eigen::Translation3d(place)));
  }

  std::vector<std::pair<geometry::ObjectModel, Eigen::Isometry3d>> objects_;
};

/// Axis of the first joint that an actuator moves, in the mount's frame.
Eigen::Vector3d axis_of(const hand::Description& hand, const hand::Actuator& actuator) {
  const auto T = hand::forward_kinematics(hand, hand::JointVector::Zero(hand.joint_count()));
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    if (hand.links[i].joint == actuator.joints.front().joint) {
      return T[i].linear() * hand.links[i].axis;
    }
  }
  return Eigen::Vector3d::Zero();
}

/// Every finger's last actuator closes it, and those before that turn about an axis like its, one
/// way mainly. Of a thumb the last two do; its first ones set it against the fingers before.
void choose_closing(hand::Description& hand) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    std::vector<hand::Actuator*> own;
    for (auto& actuator : hand.actuators) {
      if (actuator.finger == finger) own.push_back(&actuator);
    }
    if (own.empty()) continue;
    const bool thumb = finger == hand.thumb;
    const Eigen::Vector3d last = axis_of(hand, *own.back());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const bool outer = i + (thumb ? 2 : 1) >= own.size();
      const bool alike = std::abs(axis_of(hand, *own[i]).dot(last)) > kAlike;
      const auto& [low, high] = own[i]->command;
      if (outer && own[i]->closing == 0) own[i]->closing = high + low >= 0 ? 1 : -1;
      if (!outer && (thumb || !alike)) own[i]->closing = 0;
    }
  }
}

HandPosture draw(const hand::Description& hand, RandomStream& random) {
  HandPosture tried;
  for (auto* shares : {&tried.fingers, &tried.thumb}) {
    for (double& share : *shares) share = random.uniform(0, 0.4);
  }
  tried.curl = random.uniform(0.2, 1);
  tried.opposition.resize(hand.actuator_count());
  for (double& share : tried.opposition) share = random.uniform(0, 1);
  tried.attitude = {random.uniform(-0.4, kSteepest), random.uniform(-1.0, 1.0)};
  return tried;
}

HandPosture shaken(HandPosture tried, RandomStream& random) {
  const auto shake = [&](double& value, double sigma, double low, double high) {
    value = std::clamp(value + sigma * random.normal(), low, high);
  };
  for (auto* shares : {&tried.fingers, &tried.thumb}) {
    for (double& share : *shares) shake(share, 0.06, 0, 0.6);
  }
  shake(tried.curl, 0.1, 0.1, 1.5);
  for (double& share : tried.opposition) shake(share, 0.08, 0, 1);
  shake(tried.attitude.pitch, 0.12, -kSteepest, kSteepest);
  shake(tried.attitude.roll, 0.12, -1.5, 1.5);
  return tried;
}

hand::Preshape preshape_of(const hand::Description& hand, const HandPosture& best,
                           const hand::Attitude& other) {
  hand::Preshape preshape;
  preshape.open = open_hand(hand, best);
  preshape.closed = closed_ends(hand, preshape.open);
  preshape.contact_torque.resize(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    preshape.contact_torque[i] = kTouch * hand.actuators[static_cast<std::size_t>(i)].lever;
  }
  preshape.attitudes = {best.attitude, other};
  for (const double pitch : {-0.35, 0.35}) {
    preshape.attitudes.push_back(
        {std::clamp(best.attitude.pitch + pitch, -kSteepest, kSteepest), best.attitude.roll});
  }
  for (const double roll : {-0.4, 0.4}) {
    preshape.attitudes.push_back({best.attitude.pitch, best.attitude.roll + roll});
  }
  return preshape;
}

/// All numbers of a hand that the search depends on, as text.
std::string fingerprint(const hand::Description& hand) {
  std::string text = "preshape 3";
  const auto add = [&](double value) { text += fmt::format(" {:a}", value); };
  for (const hand::Link& link : hand.links) {
    for (const double value : link.T_parent_link.matrix().reshaped()) add(value);
    for (const double value : link.axis) add(value);
    text += fmt::format(" {} {}", link.parent, link.joint);
  }
  for (const hand::Actuator& one : hand.actuators) {
    for (const double value : {one.command.low, one.command.high, one.closing, one.lever})
      add(value);
    for (const auto& driven : one.joints) {
      text += fmt::format(" {} {:a} {:a}", driven.joint, driven.share, driven.offset);
    }
    text += fmt::format(" {}", one.finger);
  }
  for (const hand::Finger& finger : hand.fingers) {
    for (const double value : finger.tip.a) add(value);
    for (const double value : finger.tip.b) add(value);
    add(finger.tip.radius);
    text += fmt::format(" {}", finger.link);
  }
  for (const hand::LinkSphere& sphere : hand.spheres) {
    for (const double value : sphere.center) add(value);
    add(sphere.radius);
    text += fmt::format(" {}", sphere.link);
  }
  return text + fmt::format(" {} {}", hand.thumb, hand.palm);
}

/// What the search has found, as kept in the cache.
std::string to_bytes(const HandPosture& best, const hand::Attitude& other) {
  std::string text =
      fmt::format("{:a} {:a} {:a} {:a} {:a} {:a} {:a} {:a} {:a}", best.attitude.pitch,
                  best.attitude.roll, other.pitch, other.roll, best.fingers[0], best.fingers[1],
                  best.thumb[0], best.thumb[1], best.curl);
  for (const double value : best.opposition) text += fmt::format(" {:a}", value);
  return text;
}

bool from_bytes(const std::string& bytes, int actuators, HandPosture& best, hand::Attitude& other) {
  constexpr std::size_t kOwn = 9;
  std::istringstream text(bytes);
  std::vector<double> values;
  for (std::string word; text >> word;) values.push_back(std::strtod(word.c_str(), nullptr));
  if (values.size() != static_cast<std::size_t>(actuators) + kOwn) return false;
  best.attitude = {values[0], values[1]};
  other = {values[2], values[3]};
  best.fingers = {values[4], values[5]};
  best.thumb = {values[6], values[7]};
  best.curl = values[8];
  best.opposition = hand::ActuatorVector::Map(values.data() + kOwn, actuators);
  return true;
}

void search_preshape(const hand::Description& hand, HandPosture& best, hand::Attitude& other) {
  const Trials trials;
  RandomStream random(1, "preshape");
  for (int i = 0; i < kSamples; ++i) {
    HandPosture tried = draw(hand, random);
    tried.cost = trials.cost(hand, tried);
    if (tried.cost < best.cost) best = tried;
  }
  for (int i = 0; i < kSteps; ++i) {
    HandPosture tried = shaken(best, random);
    tried.cost = trials.cost(hand, tried);
    if (tried.cost < best.cost) best = tried;
  }
  if (best.cost > 3.5 * kNoGrasp) {
    throw BadInput("the hand holds nothing: no posture was found in which its fingers oppose");
  }
  HandPosture steep = best;
  double least = std::numeric_limits<double>::infinity();
  for (const double by : {-0.5, -0.3, 0.3, 0.5}) {
    steep.attitude.pitch = std::clamp(best.attitude.pitch + by, -kSteepest, kSteepest);
    const double cost = trials.cost(hand, steep);
    if (cost >= least) continue;
    least = cost;
    other = steep.attitude;
  }
}

hand::Preshape find_preshape(hand::Description& hand) {
  const std::string key = fingerprint(hand);
  HandPosture best;
  hand::Attitude other;
  const auto known = read_cache(key);
  if (!known || !from_bytes(*known, hand.actuator_count(), best, other)) {
    search_preshape(hand, best, other);
    write_cache(key, to_bytes(best, other));
  }
  hand.postures.far_attitudes = {other};
  hand = closing_hand(hand, best);
  return preshape_of(hand, best, other);
}

/// All fingers so far on their way to closed, the other actuators as in the open hand.
hand::ActuatorVector all_bent(const hand::Description& hand, double share) {
  hand::ActuatorVector positions = hand.postures.top.open;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing != 0) positions[i] = bent(actuator, share);
    if (actuator.closing == 0 && actuator.finger >= 0 && actuator.finger != hand.thumb) {
      positions[i] = std::clamp(0.0, actuator.command.low, actuator.command.high);
    }
  }
  return positions;
}

/// The surface of the hand in a posture, in the mount's frame.
struct Ball {
  int link;
  Eigen::Vector3d center;
  double radius;
};

std::vector<Ball> surface(const hand::Description& hand, const hand::ActuatorVector& positions) {
  const auto T = hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, positions));
  std::vector<Ball> balls;
  for (const auto& sphere : hand.spheres) {
    balls.push_back(
        {sphere.link, T[static_cast<std::size_t>(sphere.link)] * sphere.center, sphere.radius});
  }
  return balls;
}

/// Whether a hand can take a posture without its fingers pressing on one another or on the palm.
bool is_clear(const hand::Description& hand, const hand::ActuatorVector& positions) {
  return hand::is_clear_of_itself(hand, hand::joints_in_free_flexion(hand, positions),
                                  hand::joints_in_free_flexion(hand, all_bent(hand, 0)));
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
  return hand::BasePosition{Eigen::Vector3d::Zero(), {0, attitude.pitch, attitude.roll}}
      .pose()
      .linear();
}

template <class Judge>
void for_each_attitude(double rolls, const Judge& judge) {
  constexpr double kStep = 0.1;
  for (double pitch = -1.4; pitch <= 1.41; pitch += kStep) {
    for (double roll = -rolls; roll <= rolls + 1e-9; roll += kStep) judge({pitch, roll});
  }
}

/// What of the hand is within kLevel of its lowest, seen from below on a grid.
struct Underside {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double area = 0;  ///< m^2, of what lies within kProbed of the middle
};

Underside underside(const std::vector<Ball>& balls, const hand::Attitude& attitude) {
  constexpr double kCell = 0.008, kReach = 0.16;  // m
  constexpr int kCells = static_cast<int>(2 * kReach / kCell);
  const Eigen::Matrix3d R = rotation(attitude);
  Eigen::MatrixXd bottom = Eigen::MatrixXd::Constant(kCells, kCells, 1.0);
  for (const Ball& ball : balls) {
    const Eigen::Vector3d p = R * ball.center;
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
        positions[k] = actuator.closing != 0 ? start_of(actuator) : random.uniform(low, high);
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
  double largest = -1;
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
  for (const Pointing& one : found) pointing.push_back(one.hand);
  return pointing;
}

void set_bends(hand::Description& hand) {
  for (int i = 0; i < hand.actuator_count(); ++i) {
    auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const auto& [low, high] = actuator.command;
    if (actuator.finger < 0) continue;
    const double a = actuator.closing != 0 ? start_of(actuator) : hand.postures.top.open[i];
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

void derive_postures(hand::Description& hand) {
  choose_closing(hand);
  hand.postures.top = find_preshape(hand);
  hand.postures.flat = find_flat(hand);
  hand.postures.pointing = find_all_pointing(hand);
  hand.postures.stretched = all_bent(hand, 0);
  hand.postures.folded = folded(hand);
  hand.postures.released = released(hand);
  set_bends(hand);
}

}  // namespace palpate::grasping
