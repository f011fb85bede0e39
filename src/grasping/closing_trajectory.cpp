// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/closing_trajectory.hpp"

#include <algorithm>
#include <limits>

#include "palpate/geometry/query/rounded_hull.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::grasping {
namespace {

constexpr int kTipPoints = 5;
constexpr int kHullPoints = 24;
constexpr int kStepTicks = 2;  // of the closing law between two shapes
constexpr int kMaxSteps = 150;
constexpr float kOverlap = 0.002f;  // m of a link that counts as stuck

/// Points that stand for a fingertip, in its link's frame: balls about them are its surface.
std::vector<Eigen::Vector3d> tip_points(const hand::Finger& finger) {
  if (finger.hull) {
    const geometry::RoundedHull hull(finger.hull->core, finger.hull->radius);
    auto points = hull.spread_over_core(kHullPoints, finger.tip.b);
    points.push_back(finger.tip.b);
    return points;
  }
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kTipPoints; ++i) {
    const double share = static_cast<double>(i) / (kTipPoints - 1);
    points.emplace_back((1 - share) * finger.tip.a + share * finger.tip.b);
  }
  return points;
}

std::vector<Eigen::Vector3f> placed(const std::vector<Eigen::Vector3d>& points,
                                    const Eigen::Isometry3d& T_mount_link) {
  std::vector<Eigen::Vector3f> result;
  result.reserve(points.size());
  for (const Eigen::Vector3d& p : points) result.emplace_back((T_mount_link * p).cast<float>());
  return result;
}

float tip_radius(const hand::Finger& finger) {
  return static_cast<float>(finger.hull ? finger.hull->radius : finger.tip.radius);
}

Eigen::Vector4f in_mount(const hand::LinkSphere& sphere,
                         const std::vector<Eigen::Isometry3d>& T_mount_link) {
  Eigen::Vector4f result;
  result << (T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center).cast<float>(),
      static_cast<float>(sphere.radius);
  return result;
}

/// Finger that carries each link, -1 for the palm and what is behind it.
std::vector<int> finger_of_links(const hand::Description& hand) {
  std::vector<int> owner(hand.links.size(), -1);
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    for (int link = hand.fingers[static_cast<std::size_t>(finger)].link;
         link >= 0 && link != hand.palm; link = hand.links[static_cast<std::size_t>(link)].parent) {
      owner[static_cast<std::size_t>(link)] = finger;
    }
  }
  return owner;
}

}  // namespace

ClosingTrajectory closing_trajectory(const hand::Description& hand,
                                     const hand::ActuatorVector& open,
                                     const grasping::ClosingLaw& law,
                                     const hand::PerFinger<bool>& closing) {
  ClosingTrajectory path;
  path.fingers.resize(hand.fingers.size());
  path.thumb = static_cast<std::size_t>(hand.thumb);
  path.middle = static_cast<std::size_t>(hand.middle_finger());
  const std::vector<int> owner = finger_of_links(hand);
  hand::HandCommand command;
  command.positions = open;
  hand::HandReading empty;  // of a hand that follows its commands at once
  empty.torques = hand::ActuatorVector::Zero(hand.actuator_count());
  const auto unlimited = hand::ActuatorVector::Constant(hand.actuator_count(), 1e6).eval();
  const auto fingers = hand.fingers.size();
  std::vector<std::vector<Eigen::Vector3d>> tips;
  for (const hand::Finger& finger : hand.fingers) tips.push_back(tip_points(finger));
  for (int step = 0; step < kMaxSteps; ++step) {
    const auto T =
        hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, command.positions));
    for (std::size_t finger = 0; finger < fingers; ++finger) {
      path.tip_radius[finger] = tip_radius(hand.fingers[finger]);
      if (!closing[finger]) continue;
      path.fingers[finger].push_back(
          {placed(tips[finger], T[static_cast<std::size_t>(hand.fingers[finger].link)]), {}});
    }
    for (const auto& sphere : hand.spheres) {
      if (step == 0) path.open_spheres.push_back(in_mount(sphere, T));
      const int finger = owner[static_cast<std::size_t>(sphere.link)];
      if (finger < 0 || !closing[static_cast<std::size_t>(finger)]) continue;
      if (sphere.link == hand.fingers[static_cast<std::size_t>(finger)].link) continue;
      path.fingers[static_cast<std::size_t>(finger)].back().other_spheres.push_back(
          in_mount(sphere, T));
    }
    const hand::ActuatorVector before = command.positions;
    for (int tick = 0; tick < kStepTicks; ++tick) law.advance(command, empty, unlimited, closing);
    if (command.positions == before) break;
  }
  return path;
}

void end_at_other_fingers(const hand::Description& hand, const hand::JointVector& joints,
                          std::size_t finger, ClosingTrajectory& path) {
  const std::vector<int> owner = finger_of_links(hand);
  const auto T = hand::forward_kinematics(hand, joints);
  std::vector<Eigen::Vector4f> others;
  for (const auto& sphere : hand.spheres) {
    const int other = owner[static_cast<std::size_t>(sphere.link)];
    if (other >= 0 && other != static_cast<int>(finger)) others.push_back(in_mount(sphere, T));
  }
  const auto meets_other = [&](const Eigen::Vector3f& p, float radius) {
    return std::any_of(others.begin(), others.end(), [&](const Eigen::Vector4f& other) {
      return (p - other.head<3>()).norm() < radius + other.w() - kOverlap;
    });
  };
  auto& shapes = path.fingers[finger];
  const auto blocked = std::find_if(shapes.begin(), shapes.end(), [&](const FingerShape& shape) {
    return std::any_of(shape.tip.begin(), shape.tip.end(),
                       [&](const auto& p) { return meets_other(p, path.tip_radius[finger]); }) ||
           std::any_of(shape.other_spheres.begin(), shape.other_spheres.end(),
                       [&](const auto& s) { return meets_other(s.template head<3>(), s.w()); });
  });
  shapes.erase(blocked, shapes.end());
}

PlacedObject::PlacedObject(const geometry::ObjectModel& object,
                           const Eigen::Isometry3d& T_world_object,
                           const Eigen::Isometry3d& T_world_mount)
    : field_(object.field()),
      T_object_mount_((T_world_object.inverse() * T_world_mount).cast<float>()),
      T_world_mount_(T_world_mount.cast<float>()) {}

float PlacedObject::distance(const Eigen::Vector3f& p) const {
  const float distance = field_.distance(T_object_mount_ * p);
  return distance < field_.beyond() ? distance : std::numeric_limits<float>::infinity();
}

float PlacedObject::height(const Eigen::Vector3f& p) const {
  return T_world_mount_.linear().row(2).dot(p) + T_world_mount_.translation().z();
}

Eigen::Vector3d PlacedObject::normal(const Eigen::Vector3f& p) const {
  const auto sample = field_.at(T_object_mount_ * p);
  if (!sample) return Eigen::Vector3d::UnitZ();
  return (T_object_mount_.linear().transpose() * sample->gradient).cast<double>().normalized();
}

FingerMeeting meet(const PlacedObject& object, const ClosingTrajectory& path, std::size_t finger,
                   double min_height) {
  const auto& shapes = path.fingers[finger];
  const float radius = path.tip_radius[finger];
  FingerMeeting meeting;
  for (; meeting.stop < shapes.size(); ++meeting.stop) {
    const FingerShape& shape = shapes[meeting.stop];
    for (const auto& sphere : shape.other_spheres) {
      if (object.distance(sphere.head<3>()) < sphere.w() - kOverlap) return meeting;
    }
    const Eigen::Vector3f* nearest = nullptr;
    float least = std::numeric_limits<float>::infinity();
    for (const auto& p : shape.tip) {
      if (object.height(p) - radius < min_height) return meeting;
      const float distance = object.distance(p) - radius;
      if (distance >= least) continue;
      least = distance;
      nearest = &p;
    }
    if (least > 0) continue;
    meeting.contact.emplace();
    meeting.contact->finger = static_cast<int>(finger);
    meeting.contact->n = object.normal(*nearest);
    meeting.contact->p = nearest->cast<double>() - radius * meeting.contact->n;
    return meeting;
  }
  --meeting.stop;
  return meeting;
}

}  // namespace palpate::grasping
