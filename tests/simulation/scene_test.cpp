// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/scene.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <numbers>
#include <vector>

#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

/// Least inertia (kg, kg m^2) of any motion of the base, with the hand that it carries.
double min_inertia(double pitch) {
  const geometry::KnownObject object = block();
  const geometry::MeshQuery mesh(object.mesh);
  const geometry::CapsuleCollider surface(mesh);
  const Scene scene =
      compose_scene(load_hand("shadow"), believed_object(object), surface, without_noise());
  mjModel& model = *scene.model;
  const DataHandle data(mj_makeData(&model));
  data->qpos[scene.base_positions[2]] = 0.5;
  data->qpos[scene.base_positions[4]] = pitch;
  mj_forward(&model, data.get());
  std::vector<double> full(static_cast<std::size_t>(model.nv * model.nv));
  mj_fullM(&model, data.get(), full.data());
  const Eigen::Map<Eigen::MatrixXd> inertia(full.data(), model.nv, model.nv);
  const int first = model.jnt_dofadr[mj_name2id(&model, mjOBJ_JOINT, "base_x")];
  const Eigen::MatrixXd base = inertia.block(first, first, 6, 6);
  return base.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
}

// Where yaw and roll turn about one axis, a base without inertia of its own has none left.
TEST(Scene, TheBaseHasInertiaAtEveryPitch) {
  for (const double share : {0.0, 0.3, 0.5, 0.7}) {
    EXPECT_GT(min_inertia(share * std::numbers::pi), 1e-3) << share;
  }
}

}  // namespace
}  // namespace palpate::simulation
