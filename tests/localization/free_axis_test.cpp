// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "localization/searches.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {
namespace {

/// A mug that stands upright, touched round its side but for the half with the handle.
Scene mug_without_handle() {
  const geometry::ObjectModel& model = model_of("mug");
  const auto& stable_poses = model.object().stable_poses;
  const auto upright =
      std::find_if(stable_poses.begin(), stable_poses.end(),
                   [](const auto& stable_pose) { return stable_pose.R_table_object(2, 2) > 0.99; });
  TableSupport table;
  table.T_frame_table = Eigen::Isometry3d::Identity();
  table.stable_pose_weights.assign(stable_poses.size(), 0);
  table.stable_pose_weights[static_cast<std::size_t>(upright - stable_poses.begin())] = 1;
  Scene scene;
  scene.truth.linear() = upright->R_table_object;
  scene.truth.translation().z() = upright->height;
  scene.evidence.table = table;
  // The handle stands out farthest from the axis of the cup.
  Eigen::Vector3d handle = Eigen::Vector3d::Zero();
  for (const auto& vertex : model.object().mesh.vertices) {
    if (vertex.head<2>().norm() > handle.head<2>().norm()) handle = vertex;
  }
  const Eigen::Vector3d away = -handle.cwiseProduct(Eigen::Vector3d(1, 1, 0)).normalized();
  for (int angle = -70; angle <= 70; angle += 10) {
    const Eigen::Vector3d side = exp_so3({0, 0, angle * kDegree}) * away;
    const double wall = 0.2 - mesh_of(model).raycast(0.2 * side, -side, 0.4)->distance;
    if (angle % 40 == 20 || angle % 40 == -20) {
      tactile::Contact contact;
      contact.p = scene.truth * (wall * side);
      contact.n = scene.truth.linear() * side;
      scene.evidence.contacts.push_back(contact);
    }
    for (const double z : {-0.02, 0.0, 0.02}) {  // fingers, where no handle can be
      const Eigen::Vector3d beside = (wall + 0.013) * side + Eigen::Vector3d(0, 0, z);
      scene.evidence.free_space.push_back({scene.truth * beside, 0.009});
    }
  }
  return scene;
}

TEST(Localize, AMugWhoseHandleWasNotTouchedTurnsFreely) {
  const geometry::ObjectModel& model = model_of("mug");
  const Scene scene = mug_without_handle();
  const Posterior posterior = localize(model, scene.evidence, RandomStream(1));
  ASSERT_FALSE(posterior.modes.empty());
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  EXPECT_LE(posterior.modes.size(), 4U);
  const Mode& mode = posterior.modes[0];
  ASSERT_TRUE(mode.free_axis);
  EXPECT_GT(std::abs(mode.free_axis->direction.z()), std::cos(4 * kDegree));
  EXPECT_GT(mode.free_axis->extent, 70 * kDegree);
  EXPECT_LT(mode.free_axis->extent, 170 * kDegree);  // not where the fingers are
  EXPECT_TRUE(covers(posterior, scene.truth, model.object().symmetries));
}

TEST(Localize, FreeSpaceRulesPosesOut) {
  const geometry::ObjectModel& model = model_of("mug");
  Scene scene = mug_without_handle();
  const Posterior with = localize(model, scene.evidence, RandomStream(1));
  scene.evidence.free_space.clear();
  const Posterior without = localize(model, scene.evidence, RandomStream(1));
  ASSERT_TRUE(!with.modes.empty() && with.modes[0].free_axis);
  ASSERT_TRUE(!without.modes.empty() && without.modes[0].free_axis);
  EXPECT_LT(with.modes[0].free_axis->extent, without.modes[0].free_axis->extent - 10 * kDegree);
}

}  // namespace
}  // namespace palpate::localization
