// SPDX-License-Identifier: Apache-2.0
#include "grasping/preshape_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include "grasping/hand_posture.hpp"
#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::grasping {
namespace {

constexpr double kTouch = 1.2;         // N, of a fingertip that closes
constexpr double kPress = 6.0;         // N, of all fingertips, in the search
constexpr std::size_t kSamples = 160;  // of preshapes, at random
constexpr std::size_t kSteps = 120;    // of the best one, at random
constexpr double kNoGrasp = 2.0;       // cost of an object that cannot be grasped
constexpr double kGivesWay = 0.1;      // cost from which a grasp may give way in the lift
constexpr double kMissing = 0.25;      // cost of a finger whose tip does not meet the object
constexpr double kClaw = 0.5;          // of the way to closed that a claw's fingers bend back
constexpr double kRadial = 1.05;  // rad between the ways on which a radial hand's fingers close
constexpr double kFullWay = 2.0;  // rad that an actuator of speed 1 closes in the time of all

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
      open[i] =
          thumb ? low + posture.opposition[i] * (high - low) : hand::straight_command(actuator);
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
    const double way = std::max(0.2, std::abs(hand::closed_command(actuator) - open[i]));
    const double speed = way * (outer[static_cast<std::size_t>(i)] ? posture.curl : 1) / kFullWay;
    actuator.closing = std::copysign(speed, actuator.closing);
  }
  return hand;
}

hand::ActuatorVector closed_ends(const hand::Description& hand, const hand::ActuatorVector& open) {
  hand::ActuatorVector ends = open;
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.closing != 0) ends[i] = hand::closed_command(actuator);
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

/// Objects that a hand is to grasp, each in a pose on the table.
class Trials {
 public:
  /// Of household size.
  /// @param lying  with a bottle that lies
  static Trials usual(bool lying) {
    Trials trials;
    trials.add("cylinder", cylinder(0.030, 0.11), {0, 0, 0.055});
    trials.add("can", cylinder(0.040, 0.09), {0, 0, 0.045});
    trials.add("box", geometry::box_mesh({0.05, 0.05, 0.09}), {0, 0, 0.045});
    trials.add("flat box", geometry::box_mesh({0.11, 0.05, 0.05}), {0, 0, 0.025});
    if (lying) {
      trials.add("lying bottle", cylinder(0.033, 0.17), {0, 0, 0.033});
      trials.objects_.back().second.linear() =
          Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
    }
    return trials;
  }

  /// As wide as a hand of human size can span.
  static Trials wide() {
    Trials trials;
    trials.add("wide box", geometry::box_mesh({0.15, 0.09, 0.05}), {0, 0, 0.025});
    return trials;
  }

  double count() const { return static_cast<double>(objects_.size()); }

  double cost(const hand::Description& given, const HandPosture& tried) const {
    const hand::Description hand = closing_hand(given, tried);
    const auto open = open_hand(hand, tried);
    const ClosingLaw law(hand, 1.0, closed_ends(hand, open));
    const auto path = closing_trajectory(hand, open, law);
    double sum = 0;
    for (const auto& [object, T_world_object] : objects_) {
      GraspPlanOptions options;
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

/// How a fingertip moves as the straight hand begins to close, unit vector in the mount's axes.
Eigen::Vector3d closing_direction(const hand::Description& hand, std::size_t finger) {
  const auto tip_at = [&](double share) -> Eigen::Vector3d {
    hand::ActuatorVector commands(hand.actuator_count());
    for (int i = 0; i < hand.actuator_count(); ++i) {
      const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
      commands[i] =
          actuator.closing == 0 ? hand::straight_command(actuator) : bent(actuator, share);
    }
    const auto T_mount_link =
        hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, commands));
    const auto& tip = hand.fingers[finger];
    return T_mount_link[static_cast<std::size_t>(tip.link)] * tip.tip.b;
  };
  return (tip_at(0.3) - tip_at(0)).normalized();
}

/// Whether the fingers stand round the palm, each closing its own way, and not side by side: most
/// postures in which they hold what is short let what is long and lies tip out between them.
bool is_radial(const hand::Description& hand) {
  std::vector<Eigen::Vector3d> directions;
  const auto apart = [&](const Eigen::Vector3d& a) {
    return std::any_of(directions.begin(), directions.end(),
                       [&](const Eigen::Vector3d& b) { return a.dot(b) < std::cos(kRadial); });
  };
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    if (finger == hand.thumb || hand::closing_actuators(hand, finger).empty()) continue;
    const Eigen::Vector3d direction = closing_direction(hand, static_cast<std::size_t>(finger));
    if (direction.isZero()) continue;
    if (apart(direction)) return true;
    directions.push_back(direction);
  }
  return false;
}

/// Share of the way to closed at which the hand is opened widest: 0, straight, or less where all
/// fingers can bend back far, as those of a claw.
double widest_share(const hand::Description& hand) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const auto closing = hand::closing_actuators(hand, finger);
    if (closing.empty()) continue;
    const auto first = static_cast<std::size_t>(closing.front());
    const hand::Actuator& actuator = hand.actuators[first];
    const double back = actuator.closing > 0 ? actuator.command.low : actuator.command.high;
    const double start = hand::straight_command(actuator);
    if (std::abs(back - start) < kClaw * std::abs(hand::closed_command(actuator) - start)) return 0;
  }
  return -kClaw;
}

/// Of those that are searched in their own way, for the fingerprint.
std::string kind_of(const hand::Description& hand) {
  return std::string(widest_share(hand) < 0 ? " claw" : "") + (is_radial(hand) ? " radial" : "");
}

HandPosture draw(const hand::Description& hand, RandomStream& random) {
  HandPosture tried;
  const double widest = widest_share(hand);
  for (auto* shares : {&tried.fingers, &tried.thumb}) {
    for (double& share : *shares) share = random.uniform(widest, 0.4);
  }
  tried.curl = random.uniform(0.2, 1);
  tried.opposition.resize(hand.actuator_count());
  for (double& share : tried.opposition) share = random.uniform(0, 1);
  tried.attitude = {random.uniform(-0.4, kSteepest), random.uniform(-1.0, 1.0)};
  return tried;
}

HandPosture shaken(const hand::Description& hand, HandPosture tried, RandomStream& random) {
  const double widest = widest_share(hand);
  const auto shake = [&](double& value, double sigma, double low, double high) {
    value = std::clamp(value + sigma * random.normal(), low, high);
  };
  for (auto* shares : {&tried.fingers, &tried.thumb}) {
    for (double& share : *shares) shake(share, 0.06, widest, 0.6);
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

/// The hand with the large balls of each link only: the small ones in corners cost the search most
/// of its time and decide nothing.
hand::Description coarse(hand::Description hand) {
  std::vector<double> largest(hand.links.size(), 0);
  for (const hand::LinkSphere& ball : hand.spheres) {
    double& radius = largest[static_cast<std::size_t>(ball.link)];
    radius = std::max(radius, ball.radius);
  }
  std::erase_if(hand.spheres, [&](const hand::LinkSphere& ball) {
    return ball.radius < 0.5 * largest[static_cast<std::size_t>(ball.link)];
  });
  return hand;
}

using Cost = std::function<double(const HandPosture&)>;

/// The posture of lowest cost: of random ones, and then of random changes of the best.
HandPosture search(const hand::Description& hand, const Cost& cost,
                   const ProgressCallback& progress) {
  RandomStream random(1, "preshape");
  HandPosture best;
  for (std::size_t i = 0; i < kSamples + kSteps; ++i) {
    HandPosture tried = i < kSamples ? draw(hand, random) : shaken(hand, best, random);
    tried.cost = cost(tried);
    if (tried.cost < best.cost) best = tried;
    if (progress) progress(i + 1, kSamples + kSteps);
  }
  return best;
}

/// A hand that cannot hold a wide object well in the posture that is best for all others is opened
/// wider, if that helps.
void search_preshape(const hand::Description& detailed, const ProgressCallback& progress,
                     HandPosture& best, hand::Attitude& other) {
  const hand::Description hand = coarse(detailed);
  const Trials trials = Trials::usual(is_radial(detailed)), wide = Trials::wide();
  const auto usual = [&](const auto& tried) { return trials.cost(hand, tried); };
  best = search(hand, usual, progress);
  if (best.cost > (trials.count() - 0.5) * kNoGrasp) {
    throw BadInput("the hand holds nothing: no posture was found in which its fingers oppose");
  }
  if (const double narrow = wide.cost(hand, best); narrow > kGivesWay) {
    const auto both = [&](const auto& tried) { return usual(tried) + wide.cost(hand, tried); };
    const HandPosture opened = search(hand, both, progress);
    if (opened.cost < best.cost + narrow) best = opened;
  }
  HandPosture steep = best;
  double lowest = std::numeric_limits<double>::infinity();
  for (const double by : {-0.5, -0.3, 0.3, 0.5}) {
    steep.attitude.pitch = std::clamp(best.attitude.pitch + by, -kSteepest, kSteepest);
    const double cost = trials.cost(hand, steep);
    if (cost >= lowest) continue;
    lowest = cost;
    other = steep.attitude;
  }
}

}  // namespace

double bent(const hand::Actuator& actuator, double share) {
  const double start = hand::straight_command(actuator);
  return std::clamp(start + share * (hand::closed_command(actuator) - start), actuator.command.low,
                    actuator.command.high);
}

hand::Preshape find_preshape(hand::Description& hand, const ProgressCallback& progress) {
  const std::string key = fingerprint(hand, kind_of(hand));
  HandPosture best;
  hand::Attitude other;
  const auto known = read_cache(key);
  if (!known || !from_bytes(*known, hand.actuator_count(), best, other)) {
    search_preshape(hand, progress, best, other);
    write_cache(key, to_bytes(best, other));
  }
  hand.postures.far_attitudes = {other};
  hand = closing_hand(hand, best);
  return preshape_of(hand, best, other);
}

}  // namespace palpate::grasping
