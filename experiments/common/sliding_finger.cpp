// SPDX-License-Identifier: Apache-2.0
#include "sliding_finger.hpp"

#include <algorithm>
#include <utility>

#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/tactile/contacts/finger_sample.hpp"

namespace palpate::experiment {
namespace {

constexpr double kApproach = 0.03;             // m, from where the tip sets out for the surface
constexpr double kApproachSpeed = 0.03;        // m/s
constexpr std::size_t kLongestApproach = 300;  // ticks
constexpr double kDepthRate = 0.02;    // m/s for each N that the tip presses too little or much,
constexpr double kSeekRate = 0.03;     // or hardly at all
constexpr double kForgetAside = 0.15;  // s, in which what was learnt on one face fades on another
constexpr double kFarthest = 0.025;    // m, of the command from the path
constexpr double kNear = 0.002;        // m, that the tip may be off a surface that it touches
constexpr double kImmovable = 200;     // kg

}  // namespace

geometry::KnownObject fixed_object(const std::string& name, geometry::TriangleMesh mesh) {
  geometry::KnownObject object;
  object.name = name;
  object.mass = kImmovable;
  const Eigen::Vector3d centroid = geometry::mass_properties(mesh, kImmovable).centroid;
  for (Eigen::Vector3d& v : mesh.vertices) v -= centroid;
  object.T_mesh_object.translation() = centroid;
  object.mass_properties = geometry::mass_properties(mesh, kImmovable);
  double low = 0;
  for (const Eigen::Vector3d& v : mesh.vertices) low = std::min(low, v.z());
  object.stable_poses = {{Eigen::Matrix3d::Identity(), -low, 1.0}};
  object.symmetries = {Eigen::Matrix3d::Identity()};
  object.mesh = std::move(mesh);
  return object;
}

PointingFinger straight_finger(hand::FingerName finger) {
  const int index = static_cast<int>(finger);
  return PointingFinger(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")), index,
                        pointing_postures(index).front());
}

SlidingFinger::SlidingFinger(const geometry::KnownObject& object,
                             const simulation::WorldOptions& options, std::uint64_t seed,
                             PointingFinger finger)
    : mesh_(object.mesh),
      surface_(mesh_),
      world_(object, options, seed),
      finger_(std::move(finger)) {}

std::vector<Eigen::Vector3d> SlidingFinger::true_normals(const hand::HandReading& reading,
                                                         const simulation::Truth& truth) const {
  const auto T_mount_link = hand::forward_kinematics(finger_.hand(), truth.joints);
  const auto link = static_cast<std::size_t>(
      finger_.hand().fingers[static_cast<std::size_t>(finger_.finger())].link);
  const Eigen::Isometry3d T_object_tip =
      truth.T_world_object.inverse() * reading.mount.pose() * T_mount_link[link];
  std::vector<Eigen::Vector3d> normals;
  const auto& tip = finger_.tip();
  const geometry::Capsule capsule{T_object_tip * tip.a, T_object_tip * tip.b, tip.radius};
  for (const auto& contact : surface_.contacts(capsule, kNear, 2)) {
    normals.push_back(truth.T_world_object.linear() * contact.normal);
  }
  return normals;
}

/// Force with which the tip presses against n, N.
double SlidingFinger::pressing(const hand::HandReading& reading, const Eigen::Vector3d& n) const {
  double force = 0;
  for (const auto& contact :
       tactile::finger_frame(reading, finger_.hand(), finger_.finger()).contacts) {
    force -= n.dot(contact.f);
  }
  return force;
}

SlideTick SlidingFinger::step(const hand::HandCommand& command) {
  SlideTick tick;
  tick.frame.reading = world_.hand().step(command);
  tick.frame.command = command;
  const simulation::Truth truth = world_.truth();
  tick.frame.truth = {truth.T_world_object, truth.joints};
  tick.true_normals = true_normals(tick.frame.reading, truth);
  return tick;
}

std::vector<SlideTick> SlidingFinger::follow(const TipPath& path, const simulation::Start& start,
                                             double force) {
  Eigen::Vector3d offset = kApproach * path.normal[0];
  world_.reset(start, finger_.command(path.R_world_mount, path.center[0] + offset));
  std::vector<SlideTick> ticks;
  bool touches = false;
  for (std::size_t at = 0; at < path.center.size(); at += touches) {
    ticks.push_back(step(finger_.command(path.R_world_mount, path.center[at] + offset)));
    // Pressed by the face that it is on, not by that where it should be: so it gets over edges.
    const auto& normals = ticks.back().true_normals;
    const Eigen::Vector3d& n = normals.empty() ? path.normal[at] : normals[0];
    const double pressed = pressing(ticks.back().frame.reading, n);
    touches = touches || pressed > 0.2 * force || ticks.size() > kLongestApproach;
    if (touches) {
      const double rate = pressed < 0.5 * force ? kSeekRate : kDepthRate;
      offset -= hand::kTick * rate * (force - pressed) * n;
      offset -= hand::kTick / kForgetAside * (offset - offset.dot(n) * n);
      if (offset.norm() > kFarthest) offset *= kFarthest / offset.norm();
    } else {
      offset -= hand::kTick * kApproachSpeed * n;
    }
  }
  return ticks;
}

}  // namespace palpate::experiment
