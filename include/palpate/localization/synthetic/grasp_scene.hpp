// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// What one closing of the hand around a fixed object gives, without noise.
struct SceneGrasp {
  std::vector<tactile::Contact> contacts;  ///< of fingertips, points on the surface
  std::vector<bool> is_false;              ///< a fingertip stopped by something else
  std::vector<FreeSphere> hand;            ///< at the closed posture
  std::vector<FreeSphere> swept;           ///< the fingertips on their way there
};

/// A known object at a known pose, grasped several times by a kinematic hand: what touch would
/// give, without a simulator. For experiments, demonstrations and benchmarks.
struct GraspScene {
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
  bool on_table = false;  ///< frame: z up, the table at z = 0
  std::vector<SceneGrasp> grasps;
  int contacts() const;
};

struct GraspSceneOptions {
  bool table = false;        ///< the object stands, and is grasped from above and the sides
  double false_share = 0;    ///< of the fingers that something else stops on their way
  double half_width = 0.02;  ///< of the place on the table, m
  int contacts = 20;         ///< grasps end when there are so many
  int max_grasps = 9;
};

/// The object at a random pose (free: any rotation, centroid within 15 mm of the origin; table: a
/// stable pose by its probability, any yaw) and grasps of it: the open hand comes from a random
/// side until it touches, backs off, and each finger closes until its tip or the way is stopped.
GraspScene make_grasp_scene(const geometry::ObjectModel& model, const geometry::MeshQuery& mesh,
                            const hand::Description& hand, const GraspSceneOptions& options,
                            RandomStream random);

/// Evidence of a scene that the search gets, and its errors.
struct SceneEvidenceOptions {
  int contacts = 10;             ///< the first so many, in the order of the grasps
  double point_noise = 0.001;    ///< of points per axis, m
  double normal_noise = 0.1745;  ///< of normals per tangent axis, rad
  double assumed_noise = 1;      ///< what the search takes the noise to be, times the true one
  double hand_offset = 0;        ///< rms of a displacement of all contacts of a grasp, m
  double assumed_offset = 0;     ///< rms of that displacement that the search assumes, m
  double false_share = 0;        ///< as the scene's
  double half_width = 0.02;      ///< as the scene's
  bool hand = true;              ///< the hand's balls are free of the object
  bool swept = true;             ///< so are those of the tips on their way
};
Evidence scene_evidence(const GraspScene& scene, const SceneEvidenceOptions& options,
                        RandomStream random);

/// A contact as a noisy sensor gives it: the point moved by a normal vector, the normal tilted
/// about each tangent axis.
tactile::Contact disturbed(tactile::Contact contact, double point_noise, double normal_noise,
                           RandomStream& random);

/// The object at rest on the table: a stable pose by its probability, any yaw, the place uniform in
/// a square.
Eigen::Isometry3d random_rest(const geometry::ObjectModel& model, double half_width,
                              RandomStream& random);

}  // namespace palpate::localization
