// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/synthetic/grasp_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "localization/synthetic/kinematic_grasp.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

using std::numbers::pi;

constexpr double kFreeSpread = 0.015, kAimSpread = 0.02;  // m
constexpr int kMaxTries = 60;                             // grasps, many of which miss
constexpr std::size_t kMinContacts = 2;                   // of a grasp worth having

Approach free_approach(RandomStream& random) {
  return {random.unit_vector(), kAimSpread * random.normal3(), random.uniform(0, 2 * pi)};
}

/// From above or the sides, aimed at the lower 9 cm above the table.
Approach approach_above_table(RandomStream& random) {
  constexpr double kFlattest = 0.2;
  Eigen::Vector3d direction;
  do {
    direction = random.unit_vector();
    direction.z() = -std::abs(direction.z());
  } while (direction.z() > -kFlattest);
  Eigen::Vector3d target = 0.01 * random.normal3();
  target.z() = random.uniform(0.02, 0.09);
  return {direction, target, random.uniform(0, 2 * pi)};
}

Eigen::Isometry3d random_pose(RandomStream& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  T.translation() = kFreeSpread * random.normal3();
  return T;
}

bool worth_having(const SceneGrasp& grasp) {
  const bool all_false =
      std::find(grasp.is_false.begin(), grasp.is_false.end(), false) == grasp.is_false.end();
  return grasp.contacts.size() >= kMinContacts && !all_false;
}

void shift(const Eigen::Vector3d& by, Evidence& evidence, std::size_t first_contact,
           std::size_t first_ball) {
  for (std::size_t i = first_contact; i < evidence.contacts.size(); ++i) {
    evidence.contacts[i].p += by;
  }
  for (std::size_t i = first_ball; i < evidence.free_space.size(); ++i) {
    evidence.free_space[i].center += by;
  }
}

void add_grasp(const SceneGrasp& grasp, const SceneEvidenceOptions& options, RandomStream& random,
               Evidence& evidence) {
  const std::size_t first_contact = evidence.contacts.size();
  const std::size_t first_ball = evidence.free_space.size();
  for (const auto& contact : grasp.contacts) {
    if (static_cast<int>(evidence.contacts.size()) == options.contacts) break;
    auto sensed = disturbed(contact, options.point_noise, options.normal_noise, random);
    sensed.point_sigma *= options.assumed_noise;
    sensed.normal_sigma *= options.assumed_noise;
    evidence.contacts.push_back(sensed);
  }
  CommonModeBias offset;
  offset.sigma = options.assumed_offset / std::sqrt(3.0);
  for (std::size_t k = first_contact; k < evidence.contacts.size(); ++k) {
    offset.members.push_back({k});
  }
  if (offset.sigma > 0) evidence.offsets.push_back(std::move(offset));
  auto& balls = evidence.free_space;
  if (options.hand) balls.insert(balls.end(), grasp.hand.begin(), grasp.hand.end());
  if (options.swept) balls.insert(balls.end(), grasp.swept.begin(), grasp.swept.end());
  shift(options.hand_offset / std::sqrt(3.0) * random.normal3(), evidence, first_contact,
        first_ball);
}

}  // namespace

int GraspScene::contacts() const {
  std::size_t count = 0;
  for (const auto& grasp : grasps) count += grasp.contacts.size();
  return static_cast<int>(count);
}

Eigen::Isometry3d random_rest(const geometry::ObjectModel& model, double half_width,
                              RandomStream& random) {
  const auto& stable_poses = model.object().stable_poses;
  double left = random.uniform();
  std::size_t s = 0;
  while (s + 1 < stable_poses.size() && left >= stable_poses[s].probability)
    left -= stable_poses[s++].probability;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = exp_so3({0, 0, random.uniform(-pi, pi)}) * stable_poses[s].R_table_object;
  const double x = random.uniform(-half_width, half_width);
  T.translation() << x, random.uniform(-half_width, half_width), stable_poses[s].height;
  return T;
}

GraspScene make_grasp_scene(const geometry::ObjectModel& model, const geometry::MeshQuery& mesh,
                            const hand::Description& hand, const GraspSceneOptions& options,
                            RandomStream random) {
  GraspScene scene;
  scene.on_table = options.table;
  scene.truth =
      options.table ? random_rest(model, options.half_width, random) : random_pose(random);
  const KinematicGrasp close(model, mesh, hand, scene.truth, options.table);
  for (int i = 0; i < kMaxTries && scene.contacts() < options.contacts &&
                  static_cast<int>(scene.grasps.size()) < options.max_grasps;
       ++i) {
    const Approach approach = options.table ? approach_above_table(random) : free_approach(random);
    SceneGrasp grasp = close(approach, options.false_share, random);
    for (auto& contact : grasp.contacts) contact.time = static_cast<double>(scene.grasps.size());
    if (worth_having(grasp)) scene.grasps.push_back(std::move(grasp));
  }
  return scene;
}

tactile::Contact disturbed(tactile::Contact contact, double point_noise, double normal_noise,
                           RandomStream& random) {
  const Eigen::Matrix3d tangent = frame_with_z(contact.n);
  const double a = random.normal(), b = random.normal();
  contact.n += normal_noise * (a * tangent.col(0) + b * tangent.col(1));
  contact.n.normalize();
  contact.p += point_noise * random.normal3();
  contact.point_sigma = point_noise;
  contact.normal_sigma = normal_noise;
  return contact;
}

Evidence scene_evidence(const GraspScene& scene, const SceneEvidenceOptions& options,
                        RandomStream random) {
  constexpr double kMinFalse = 0.01;
  Evidence evidence;
  evidence.false_contact_share = std::max(kMinFalse, options.false_share);
  if (scene.on_table) {
    TableSupport table;
    table.T_frame_table = Eigen::Isometry3d::Identity();
    table.half_width = options.half_width;
    evidence.table = table;
  }
  for (const SceneGrasp& grasp : scene.grasps) {
    if (static_cast<int>(evidence.contacts.size()) >= options.contacts) break;
    add_grasp(grasp, options, random, evidence);
  }
  return evidence;
}

}  // namespace palpate::localization
