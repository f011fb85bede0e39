// SPDX-License-Identifier: Apache-2.0
#include "localization/synthetic/kinematic_grasp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr double kStartDistance = 0.16, kPastAim = 0.03;  // m, of the palm's way in
constexpr double kMinStep = 0.0008, kMaxStep = 0.02;      // m, of it
constexpr double kTouching = 0.001;                       // m between palm and object
constexpr double kMinBackOff = 0.002, kMaxBackOff = 0.015;
constexpr double kGraspCentre = 0.075;  // m along the palm's z axis: where fingers meet
constexpr int kTicks = 75, kTicksPerGuardedMove = 6;   // of the closing
constexpr double kBaseStep = 0.03, kCurlStep = 0.033;  // rad a tick
constexpr double kMaxBase = 1.5, kMaxCurl = 1.6;
constexpr int kClosingBisections = 6;
constexpr double kContactGap = 0.0012;  // m between a stopped fingertip and what it touches
constexpr double kOtherShare = 60;      // ticks over which a finger may meet something else
constexpr std::size_t kThumb = 0;

/// The finger whose chain of links below the palm holds the link; -1 for the palm and what is
/// before it.
int finger_of_link(const hand::Description& hand, int link) {
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    for (int l = hand.fingers[finger].link; l >= 0 && l != hand.palm;
         l = hand.links[static_cast<std::size_t>(l)].parent) {
      if (l == link) return static_cast<int>(finger);
    }
  }
  return -1;
}

void set(hand::JointVector& joints, std::size_t finger, char number, double angle) {
  const std::string name = std::string(hand::kShadowFingerNames[finger]) + "J" + number;
  joints[hand::shadow_hand().joint(name)] = angle;
}

}  // namespace

KinematicGrasp::KinematicGrasp(const geometry::ObjectModel& model, const geometry::MeshQuery& mesh,
                               const hand::Description& hand,
                               const Eigen::Isometry3d& T_world_object, bool on_table)
    : model_(model),
      mesh_(mesh),
      hand_(hand),
      T_object_world_(T_world_object.inverse()),
      box_(model.bounds().cast<double>()),
      on_table_(on_table) {
  for (const auto& ball : hand.spheres) finger_of_.push_back(finger_of_link(hand, ball.link));
}

bool KinematicGrasp::is_tip(std::size_t ball, std::size_t finger) const {
  return hand_.spheres[ball].link == hand_.fingers[finger].link;
}

std::vector<FreeSphere> KinematicGrasp::balls(const Posture& posture) const {
  hand::JointVector joints = hand::JointVector::Zero(hand_.joint_count());
  for (std::size_t f = 0; f < posture.fingers.size(); ++f) {
    const auto& [base, curl, stage, at, other] = posture.fingers[f];
    if (f == kThumb) {
      set(joints, f, '5', posture.spread[f]);
      set(joints, f, '4', 1.15);
      set(joints, f, '2', -0.5 + 0.8 * base);
      set(joints, f, '1', -0.1 + 0.8 * curl);
    } else {
      set(joints, f, '4', posture.spread[f]);
      set(joints, f, '3', base);
      set(joints, f, '2', std::min(1.57, curl));
      set(joints, f, '1', std::min(1.57, 0.8 * curl));
    }
  }
  const auto T_mount_link = hand::forward_kinematics(hand_, joints);
  const Eigen::Isometry3d T_world_mount =
      posture.T_world_palm * T_mount_link[static_cast<std::size_t>(hand_.palm)].inverse();
  std::vector<FreeSphere> result;
  for (const auto& ball : hand_.spheres) {
    const auto& T = T_mount_link[static_cast<std::size_t>(ball.link)];
    result.push_back({T_world_mount * (T * ball.center), ball.radius});
  }
  return result;
}

double KinematicGrasp::gap(const FreeSphere& ball) const {
  const Eigen::Vector3d p = T_object_world_ * ball.center;
  const double beside = box_.exteriorDistance(p);  // the field ends near the object
  const double distance = static_cast<double>(model_.field().distance(p.cast<float>()));
  const double to_object = std::max(beside, distance) - ball.radius;
  return on_table_ ? std::min(to_object, ball.center.z() - ball.radius) : to_object;
}

bool KinematicGrasp::approached(const Approach& approach, Posture& posture,
                                RandomStream& random) const {
  const Eigen::Matrix3d around = frame_with_z(-approach.direction);
  const Eigen::Vector3d z =
      std::cos(approach.roll) * around.col(0) + std::sin(approach.roll) * around.col(1);
  Eigen::Matrix3d R;  // the palm faces -y
  R << (-approach.direction).cross(z), -approach.direction, z;
  const Eigen::Vector3d start = approach.target - R * Eigen::Vector3d(0, 0, kGraspCentre);
  posture.T_world_palm.linear() = R;
  posture.T_world_palm.translation() = start;
  const auto at_start = balls(posture);
  double along = -kStartDistance;
  while (along < kPastAim) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& ball : at_start) {
      least = std::min(least, gap({ball.center + along * approach.direction, ball.radius}));
    }
    if (least < kTouching) break;
    along += std::max(kMinStep, 0.7 * std::min(least, kMaxStep));
  }
  if (along <= -kStartDistance) return false;
  along -= random.uniform(kMinBackOff, kMaxBackOff);
  posture.T_world_palm.translation() += along * approach.direction;
  return true;
}

/// The finger goes back to where it just does not penetrate.
void KinematicGrasp::stop_at_contact(Posture& posture, const Posture& before,
                                     std::size_t finger) const {
  const Finger from = before.fingers[finger], to = posture.fingers[finger];
  double low = 0, high = 1;
  const auto part_way = [&](double share) {
    posture.fingers[finger].base = from.base + share * (to.base - from.base);
    posture.fingers[finger].curl = from.curl + share * (to.curl - from.curl);
  };
  for (int i = 0; i < kClosingBisections; ++i) {
    const double middle = 0.5 * (low + high);
    part_way(middle);
    const auto now = balls(posture);
    bool free = true;
    for (std::size_t b = 0; b < now.size(); ++b) {
      if (finger_of_[b] == static_cast<int>(finger)) free = free && gap(now[b]) >= 0;
    }
    (free ? low : high) = middle;
  }
  part_way(low);
}

void KinematicGrasp::step(Posture& posture, int tick) const {
  const Posture before = posture;
  for (Finger& finger : posture.fingers) {
    if (finger.stage == Stage::closing) finger.base += kBaseStep;
    if (finger.stage != Stage::stopped) finger.curl += kCurlStep;
  }
  const auto now = balls(posture);
  for (std::size_t f = 0; f < posture.fingers.size(); ++f) {
    Finger& finger = posture.fingers[f];
    if (finger.stage == Stage::stopped) continue;
    if (finger.stopped_at && tick > *finger.stopped_at * kOtherShare) {
      finger.stage = Stage::stopped;
      finger.met_other = true;
      continue;
    }
    double least = 0;
    std::size_t deepest = now.size();
    for (std::size_t b = 0; b < now.size(); ++b) {
      if (finger_of_[b] != static_cast<int>(f) || gap(now[b]) >= least) continue;
      least = gap(now[b]);
      deepest = b;
    }
    if (deepest < now.size()) {
      stop_at_contact(posture, before, f);
      const bool ends = is_tip(deepest, f) || finger.stage == Stage::curling;
      finger.stage = ends ? Stage::stopped : Stage::curling;
    }
    if (finger.base > kMaxBase && finger.stage == Stage::closing) finger.stage = Stage::curling;
    if (finger.curl > kMaxCurl) finger.stage = Stage::stopped;
  }
}

FreeSphere KinematicGrasp::tip_ball(const std::vector<FreeSphere>& balls,
                                    std::size_t finger) const {
  FreeSphere nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < balls.size(); ++b) {
    if (!is_tip(b, finger)) continue;
    const Eigen::Vector3d p = T_object_world_ * balls[b].center;
    const double gap_here = mesh_.closest_point(p).distance - balls[b].radius;
    if (gap_here >= least) continue;
    least = gap_here;
    nearest = balls[b];
  }
  return nearest;
}

std::optional<tactile::Contact> KinematicGrasp::tip_contact(const std::vector<FreeSphere>& balls,
                                                            std::size_t finger) const {
  const FreeSphere tip = tip_ball(balls, finger);
  const Eigen::Vector3d center = T_object_world_ * tip.center;
  const auto closest = mesh_.closest_point(center);
  if (closest.distance - tip.radius > kContactGap) return std::nullopt;
  tactile::Contact contact;
  contact.finger = static_cast<int>(finger);
  const Eigen::Isometry3d T_world_object = T_object_world_.inverse();
  contact.p = T_world_object * closest.point;
  contact.n = T_world_object.linear() * (center - closest.point).normalized();
  return contact;
}

SceneGrasp KinematicGrasp::operator()(const Approach& approach, double false_share,
                                      RandomStream& random) const {
  Posture posture;
  const double spread = random.uniform(-1, 1);
  posture.spread = {random.uniform(0.3, 0.9), -0.1 * spread, -0.03 * spread, 0.03 * spread,
                    0.1 * spread};
  for (Finger& finger : posture.fingers) {
    const double at = random.uniform(0.1, 0.7);
    if (random.uniform() < false_share) finger.stopped_at = at;
  }
  SceneGrasp grasp;
  if (!approached(approach, posture, random)) return grasp;
  const auto moving = [](const Finger& finger) { return finger.stage != Stage::stopped; };
  for (int tick = 1; tick <= kTicks && std::ranges::any_of(posture.fingers, moving); ++tick) {
    step(posture, tick);
    if (tick % kTicksPerGuardedMove != 0) continue;
    const auto now = balls(posture);
    for (std::size_t b = 0; b < now.size(); ++b) {
      const auto finger = static_cast<std::size_t>(std::max(0, finger_of_[b]));
      if (finger_of_[b] >= 0 && is_tip(b, finger) && moving(posture.fingers[finger])) {
        grasp.swept.push_back(now[b]);
      }
    }
  }
  grasp.hand = balls(posture);
  for (std::size_t f = 0; f < posture.fingers.size(); ++f) {
    if (posture.fingers[f].met_other) {
      tactile::Contact other;
      other.finger = static_cast<int>(f);
      other.n = random.unit_vector();
      const FreeSphere tip = tip_ball(grasp.hand, f);
      other.p = tip.center - tip.radius * other.n;
      grasp.contacts.push_back(other);
      grasp.is_false.push_back(true);
    } else if (const auto contact = tip_contact(grasp.hand, f)) {
      grasp.contacts.push_back(*contact);
      grasp.is_false.push_back(false);
    }
  }
  return grasp;
}

}  // namespace palpate::localization
