// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <vector>

#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand_files.hpp"
#include "simulation/scenes.hpp"
#include "simulation/world/simulated_hand.hpp"

namespace palpate::simulation {
namespace {

/// Least inertia (kg, kg m^2) of any motion of the mount, with the hand that it carries.
double min_inertia(double pitch) {
  const geometry::KnownObject object = block();
  const geometry::MeshQuery mesh(object.mesh);
  const geometry::CapsuleCollider surface(mesh);
  const Scene scene =
      compose_scene(load_hand("shadow"), believed_object(object), surface, without_noise());
  mjModel& model = *scene.model;
  const DataHandle data(mj_makeData(&model));
  data->qpos[scene.mount_positions[2]] = 0.5;
  data->qpos[scene.mount_positions[4]] = pitch;
  mj_forward(&model, data.get());
  std::vector<double> full(static_cast<std::size_t>(model.nv * model.nv));
  mj_fullM(&model, data.get(), full.data());
  const Eigen::Map<Eigen::MatrixXd> inertia(full.data(), model.nv, model.nv);
  const int first = model.jnt_dofadr[mj_name2id(&model, mjOBJ_JOINT, own_name("mount_x").c_str())];
  const Eigen::MatrixXd mount = inertia.block(first, first, 6, 6);
  return mount.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
}

// Where yaw and roll turn about one axis, a mount without inertia of its own has none left.
TEST(Scene, TheMountHasInertiaAtEveryPitch) {
  for (const double share : {0.0, 0.3, 0.5, 0.7}) {
    EXPECT_GT(min_inertia(share * std::numbers::pi), 1e-3) << share;
  }
}

/// Of a hand whose palm has this mass (kg), so far (m) behind the mount.
hand::MountLimits limits_of_hand(double mass, double lever) {
  const auto text =
      replaced(kHandMjcf, "<geom type=\"box\"",
               fmt::format("<inertial pos=\"-{} 0 0\" mass=\"{}\" diaginertia=\"0.01 0.01 0.01\"/>"
                           "<geom type=\"box\"",
                           lever, mass));
  const hand::Description hand = describe_hand(write_hand("heavy.xml", text)).hand;
  const geometry::KnownObject object = block();
  const geometry::MeshQuery mesh(object.mesh);
  const geometry::CapsuleCollider surface(mesh);
  const WorldOptions options = without_noise();
  const Scene scene = compose_scene(hand, believed_object(object), surface, options);
  const DataHandle data(mj_makeData(scene.model.get()));
  SimulatedHand simulated(scene, *data, hand, options, RandomStream(1, "hand"));
  simulated.reset({hand::ActuatorVector::Zero(hand.actuator_count()), {}});
  return simulated.mount_limits();
}

// Else its own inertia loads the mount by more than the 40 N at which the robot stops.
TEST(Scene, AHeavyHandIsAcceleratedGently) {
  EXPECT_TRUE(std::isinf(limits_of_hand(2, 0.2).acceleration));
  EXPECT_EQ(limits_of_hand(3, 0.4).turn_acceleration, 10);
  EXPECT_EQ(limits_of_hand(6, 0.02).acceleration, 3);
}

TEST(Scene, ASecondObjectRestsOnTheTableAndIsSensed) {
  const geometry::KnownObject object = block();
  const geometry::MeshQuery mesh(object.mesh);
  const geometry::CapsuleCollider surface(mesh);
  WorldOptions options = without_noise();
  const auto compose = [&] {
    return compose_scene(load_hand("shadow"), believed_object(object), surface, options);
  };
  EXPECT_EQ(compose().second, -1);
  options.second_object = true;
  const Scene scene = compose();
  ASSERT_GE(scene.second, 0);
  EXPECT_TRUE(scene.is_sensed(scene.second));
  EXPECT_FALSE(scene.stands_fast(scene.second));
  const DataHandle data(mj_makeData(scene.model.get()));
  data->qpos[scene.mount_positions[2]] = data->ctrl[scene.base_actuators[2]] = 0.5;
  data->qpos[scene.object_position] = 0.3;
  data->qpos[scene.object_position + 2] = 0.3;
  mjtNum* const second = data->qpos + scene.second_position;
  second[2] = kSecondHalf.z() + 0.001;
  for (int step = 0; step < 100; ++step) mj_step(scene.model.get(), data.get());
  EXPECT_NEAR(second[2], kSecondHalf.z(), 5e-4);
  EXPECT_NEAR(second[0], 0, 1e-4);
}

}  // namespace
}  // namespace palpate::simulation
