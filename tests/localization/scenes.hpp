// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/localization/localizer.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"

namespace palpate::localization {

/// A known object at a known pose with contacts on it: what a touch would give, without a
/// simulator.
struct Scene {
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  Evidence evidence;
};

struct SceneOptions {
  int contacts = 10;
  double point_noise = 0.001;    // per axis, m
  double normal_noise = 0.1745;  // per tangent axis, rad
  double false_share = 0;        // of the contacts, anywhere on a ball round the object
  bool table = false;            // the object stands, and the evidence says so
  double half_width = 0.03;      // of the place on the table, m
};

/// Built-in objects prepared once a program.
inline const geometry::ObjectModel& model_of(const std::string& name) {
  static std::map<std::string, std::unique_ptr<geometry::ObjectModel>> models;
  auto& model = models[name];
  if (!model) model = std::make_unique<geometry::ObjectModel>(geometry::load_known_object(name));
  return *model;
}

inline const geometry::MeshQuery& mesh_of(const geometry::ObjectModel& model) {
  static std::map<const geometry::ObjectModel*, std::unique_ptr<geometry::MeshQuery>> meshes;
  auto& mesh = meshes[&model];
  if (!mesh) mesh = std::make_unique<geometry::MeshQuery>(model.object().mesh);
  return *mesh;
}

inline Eigen::Isometry3d random_pose(RandomStream& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  T.translation() = 0.1 * random.normal3();
  return T;
}

/// Points of the surface (object's frame) that a finger from 1-3 sides (`up`: not from below)
/// meets.
inline std::vector<tactile::Contact> touchable(const geometry::ObjectModel& model,
                                               RandomStream& random, const Eigen::Vector3d* up) {
  std::vector<Eigen::Vector3d> sides;
  const std::size_t count = 1 + random.index(3);
  while (sides.size() < count) {
    const Eigen::Vector3d side = random.unit_vector();
    if (!up || side.dot(*up) > 0) sides.push_back(side);
  }
  std::vector<tactile::Contact> result;
  while (result.size() < 300) {
    const auto& sample = model.surface()[random.index(model.surface().size())];
    const Eigen::Vector3d& side = sides[random.index(count)];
    tactile::Contact contact;
    contact.p = sample.p.cast<double>();
    contact.n = sample.n.cast<double>();
    if (contact.n.dot(side) < 0.3 || (up && contact.n.dot(*up) < -0.3)) continue;
    if (mesh_of(model).raycast(contact.p + 1e-4 * contact.n, side, 0.3)) continue;
    result.push_back(contact);
  }
  return result;
}

/// `count` of the contacts, each the farthest from those before it.
inline std::vector<tactile::Contact> spread(std::vector<tactile::Contact> contacts, int count) {
  std::vector<tactile::Contact> chosen;
  std::vector<double> gap(contacts.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  while (static_cast<int>(chosen.size()) < count) {
    chosen.push_back(contacts[next]);
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      gap[k] = std::min(gap[k], (contacts[k].p - contacts[next].p).squaredNorm());
    }
    next = static_cast<std::size_t>(std::max_element(gap.begin(), gap.end()) - gap.begin());
  }
  return chosen;
}

inline void disturb(tactile::Contact& contact, const SceneOptions& options, RandomStream& random) {
  const Eigen::Matrix3d tangent = frame_with_z(contact.n);
  const double a = random.normal(), b = random.normal();
  contact.n += options.normal_noise * (a * tangent.col(0) + b * tangent.col(1));
  contact.n.normalize();
  contact.p += options.point_noise * random.normal3();
  if (random.uniform() < options.false_share) {
    contact.n = random.unit_vector();
    contact.p = 0.06 * random.unit_vector();
  }
  contact.point_sigma = std::max(options.point_noise, 0.0003);
  contact.normal_sigma = std::max(options.normal_noise, 0.03);
}

inline Scene make_scene(const geometry::ObjectModel& model, const SceneOptions& options,
                        RandomStream random) {
  Scene scene;
  if (options.table) {
    TableSupport table;
    table.T_frame_table = Eigen::Isometry3d::Identity();
    table.T_frame_table.translation() << 0.4, -0.1, 0.2;
    table.tilt_sigma = 0.03;
    table.height_sigma = 0.002;
    table.half_width = options.half_width;
    scene.truth = table.T_frame_table * random_rest(model, table.half_width, random);
    scene.evidence.table = table;
  } else {
    scene.truth = random_pose(random);
  }
  const Eigen::Vector3d up = scene.truth.linear().row(2).transpose();
  auto contacts = spread(touchable(model, random, options.table ? &up : nullptr), options.contacts);
  for (tactile::Contact& contact : contacts) {
    disturb(contact, options, random);
    contact.p = scene.truth * contact.p;
    contact.n = scene.truth.linear() * contact.n;
  }
  scene.evidence.contacts = std::move(contacts);
  scene.evidence.false_contact_share = std::max(0.02, options.false_share);
  return scene;
}

inline bool within_tolerance(const PoseError& error) {
  return error.rotation < 5 * M_PI / 180 && error.translation < 0.01;
}

}  // namespace palpate::localization
