// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_task.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "tasks/relocate/relocate_model.hpp"

namespace palpate::relocate {
namespace {

/// From where on object and table push each other apart, m: the margins of both.
constexpr double kMargin = 0.0035;

RelocateAction rest() { return RelocateAction::Zero(); }

TEST(RelocateTask, HasTheSizesOfThePublishedTask) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model);
  EXPECT_EQ(task.positions().size(), 37);
  EXPECT_NEAR(model.object_mass(), 0.301, 1e-12);
  EXPECT_EQ(task.observation().size(), kRelocateObservations);
  // Ranges of the base's actuators in the hand's file.
  EXPECT_DOUBLE_EQ(model.action_half_range()[0], 0.25);
  EXPECT_DOUBLE_EQ(model.action_center()[1], 0.1);
}

TEST(RelocateTask, HasTheWristAndThePlaceOfThePublishedHand) {
  const RelocateModel owner(relocate_primitive_mug());
  const mjModel& model = *owner.impl().scene.model;
  const int wrist = mj_name2id(&model, mjOBJ_JOINT, "WRJ0");
  ASSERT_GE(wrist, 0);
  const int dof = model.jnt_dofadr[wrist];
  EXPECT_DOUBLE_EQ(model.dof_damping[dof], 0.05);  // adroit_relocate.xml of DexMV
  EXPECT_DOUBLE_EQ(model.dof_armature[dof], 0.001);
  const int arm = mj_name2id(&model, mjOBJ_BODY, "forearm");
  EXPECT_DOUBLE_EQ(model.body_pos[3 * arm + 1], -0.7);
}

TEST(RelocateTask, StartsWhereItIsGiven) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model);
  task.reset({{-0.06, 0.02}, {0.05, -0.1, 0.2}});
  const auto o = task.observation();
  EXPECT_EQ(o.head<30>().norm(), 0);  // the hand is at rest at its zero
  EXPECT_LT((o.segment<3>(36) - Eigen::Vector3d(-0.11, 0.12, 0.04065 - 0.2)).norm(), 1e-9);
  EXPECT_LT((o.segment<3>(33) - o.segment<3>(30) - o.segment<3>(36)).norm(), 1e-12);
  EXPECT_EQ(task.proprioception().velocity.norm(), 0);
}

TEST(RelocateTask, DrawsStartsWithinTheTasksRanges) {
  for (const double scale : {0.25, 1.0}) {
    RandomStream random(3);
    for (int i = 0; i < 200; ++i) {
      const auto start = sample_relocate_start(random, scale);
      EXPECT_DOUBLE_EQ(start.object.x(), 0.15 * scale - 0.1);
      EXPECT_LE(std::abs(start.object.y()), 0.15 * scale);
      EXPECT_TRUE(start.target.x() >= -0.3 && start.target.x() <= 0.1);
      EXPECT_LE(std::abs(start.target.y()), 0.15);
      EXPECT_TRUE(start.target.z() >= 0.15 && start.target.z() <= 0.25);
    }
  }
}

TEST(RelocateTask, WithoutContactTheRewardIsTheDistanceOfThePalm) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model);
  task.reset({{-0.06, 0}, {0, 0, 0.2}});
  for (int i = 0; i < 5; ++i) {
    const auto step = task.step(rest());
    EXPECT_FALSE(step.contact);
    const auto o = task.observation();
    EXPECT_NEAR(step.reward, -0.1 * o.segment<3>(30).norm(), 1e-12);
    EXPECT_NEAR(step.distance, o.segment<3>(36).norm(), 1e-12);
  }
}

TEST(RelocateTask, TheMugComesToRestOnTheTable) {
  for (const auto solver :
       {RelocateSolver::faithful, RelocateSolver::newton, RelocateSolver::fast}) {
    RelocatePhysics physics;
    physics.solver = solver;
    const RelocateModel model(relocate_primitive_mug(), physics);
    RelocateTask task(model);
    task.reset({{0.05, 0.1}, {0, 0, 0.2}});
    for (int i = 0; i < 60; ++i) task.step(rest());
    const auto q = task.positions();
    // The mug's floor is 31.2 mm below its frame.
    EXPECT_NEAR(q[32], 0.0312 + kMargin, 5e-4) << to_string(solver);
    EXPECT_LT((q.segment<2>(30) - Eigen::Vector2d(0.05, 0.1)).norm(), 0.004) << to_string(solver);
  }
}

TEST(RelocateTask, RepeatsAnEpisodeBitForBit) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask first(model), second(model);
  const RelocateStart start{{-0.06, 0.01}, {0, 0, 0.2}};
  second.reset({{0.02, 0}, {0.1, 0, 0.2}});
  for (int i = 0; i < 10; ++i) second.step(RelocateAction::Constant(0.3));
  first.reset(start);
  second.reset(start);
  for (int i = 0; i < 20; ++i) {
    const RelocateAction action = RelocateAction::Constant(0.05 * i);
    EXPECT_EQ(first.step(action).reward, second.step(action).reward);
  }
  EXPECT_EQ(first.positions(), second.positions());
}

TEST(RelocateTask, ClipsActions) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask first(model), second(model);
  for (int i = 0; i < 5; ++i) {
    first.step(RelocateAction::Constant(50));
    second.step(RelocateAction::Constant(1));
  }
  EXPECT_EQ(first.positions(), second.positions());
}

TEST(RelocateTask, AnActionThatIsNotFiniteEndsTheEpisode) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model);
  RelocateAction action = rest();
  action[7] = std::numeric_limits<double>::quiet_NaN();
  const auto step = task.step(action);
  EXPECT_TRUE(step.diverged);
  EXPECT_EQ(step.reward, 0);
  task.reset({});
  EXPECT_FALSE(task.step(rest()).diverged);
}

TEST(RelocateTask, TakesAnyMesh) {
  const auto box = geometry::box_mesh({0.05, 0.04, 0.08});
  const RelocateModel model(relocate_mesh_object("brick", box, 0.2));
  RelocateTask task(model);
  EXPECT_NEAR(model.object_mass(), 0.2, 1e-12);
  task.reset({{-0.05, 0.1}, {0, 0, 0.2}});
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(task.step(rest()).diverged);
  EXPECT_NEAR(task.positions()[32], 0.04 + kMargin, 5e-4);
}

/// The inertia that the simulator has, in the axes of the object's frame.
Eigen::Matrix3d simulated_inertia(const RelocateModel& owner) {
  const auto& scene = owner.impl().scene;
  const mjtNum* const q = scene.model->body_iquat + 4 * scene.object;
  const Eigen::Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  const Eigen::Vector3d moments =
      Eigen::Vector3d::Map(scene.model->body_inertia + 3 * scene.object);
  return R * moments.asDiagonal() * R.transpose();
}

TEST(RelocateTask, AMeshHasItsProductsOfInertia) {
  const Eigen::Isometry3d T(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  const auto tilted = geometry::transformed(T, geometry::box_mesh({0.05, 0.04, 0.08}));
  const Eigen::Matrix3d inertia = geometry::mass_properties(tilted, 0.2).inertia;
  ASSERT_GT(std::abs(inertia(0, 2)), 0.05 * inertia(0, 0));
  for (const double size : {1.0, 0.9}) {
    const RelocateModel model(scaled(relocate_mesh_object("brick", tilted, 0.2), size));
    EXPECT_LT((simulated_inertia(model) - size * size * inertia).norm(), 1e-9 * inertia.norm());
  }
}

/// Bit for bit what it was before products of inertia were read.
TEST(RelocateTask, InertiaWithoutProductsStaysAsItIs) {
  const auto box = relocate_mesh_object("brick", geometry::box_mesh({0.05, 0.04, 0.08}), 0.2);
  for (const RelocateObject& object : {box, relocate_primitive_mug()}) {
    const RelocateModel owner(object);
    const auto& scene = owner.impl().scene;
    const Eigen::Vector4d q = Eigen::Vector4d::Map(scene.model->body_iquat + 4 * scene.object);
    EXPECT_EQ(q, Eigen::Vector4d(1, 0, 0, 0)) << object.name;
    const Eigen::Vector3d moments =
        Eigen::Vector3d::Map(scene.model->body_inertia + 3 * scene.object);
    EXPECT_EQ(moments, object.inertia.diagonal()) << object.name;
  }
}

TEST(RelocateTask, ABiasIsInWhatIsObservedAndNotInTheWorld) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model), biased(model);
  RelocateStart start{{-0.06, 0.02}, {0.05, -0.1, 0.2}};
  task.reset(start);
  start.object_bias = {0.01, -0.02, 0.03};
  biased.reset(start);
  const RelocateObservation change = biased.observation() - task.observation();
  EXPECT_LT((change.segment<3>(kPalmFromObject) + start.object_bias).norm(), 1e-12);
  EXPECT_LT((change.segment<3>(kObjectFromTarget) - start.object_bias).norm(), 1e-12);
  EXPECT_EQ(change.head<kPalmFromObject>().norm() + change.segment<3>(kPalmFromTarget).norm(), 0);
  EXPECT_EQ(task.step(rest()).reward, biased.step(rest()).reward);
  start.object_bias.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(task.reset(start), BadInput);
}

/// The place at rest until two fingertips touch; then that of a period ago, moved with the palm.
TEST(RelocateTask, ASparseObservationIsLateAndGoesWithThePalm) {
  const Eigen::Vector3d place(0, 0, 0.03), pushed(0.02, 0, 0.03);
  const auto at = [](double z) { return Eigen::Vector3d(0, 0, z); };
  SparseObservation seen;
  seen.reset(place, at(0.1), 2);
  for (int i = 0; i < 4; ++i) seen.update(pushed, at(0.1), 1);  // one finger has no information
  EXPECT_EQ(seen.position(), place);
  seen.update(pushed, at(0.1), 2);
  seen.update(pushed, at(0.1), 2);  // observed, on its way
  EXPECT_EQ(seen.position(), place);
  seen.update(pushed, at(0.1), 2);
  seen.update(pushed, at(0.1), 2);
  EXPECT_EQ(seen.position(), pushed);
  seen.update(pushed + at(0.05), at(0.15), 2);
  EXPECT_TRUE(seen.position().isApprox(pushed + at(0.05), 1e-12));
  seen.update(pushed, at(0.2), 0);  // lost
  EXPECT_TRUE(seen.position().isApprox(pushed + at(0.05), 1e-12));
  seen.reset(place, at(0.1), 0);
  seen.update(pushed, at(0.1), 0);
  EXPECT_EQ(seen.position(), pushed);
}

TEST(RelocateTask, NoisyEncodersTellTheVelocityRoughly) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask exact(model), noisy(model);
  RelocateStart start{{-0.06, 0.02}, {0.05, -0.1, 0.2}};
  exact.reset(start);
  start.encoder_noise = 1e-4;
  noisy.reset(start);
  double error = 0, speed = 0;
  constexpr int kSteps = 40;
  for (int i = 0; i < kSteps; ++i) {
    const RelocateAction action = RelocateAction::Constant(0.02 * i);
    exact.step(action);
    noisy.step(action);
    const Eigen::Vector3d truth = exact.proprioception().velocity.head<3>();
    error += (noisy.proprioception().velocity.head<3>() - truth).norm() / kSteps;
    speed += truth.norm() / kSteps;
  }
  EXPECT_EQ(exact.positions(), noisy.positions());
  EXPECT_GT(error, 0.005);  // a difference of two readings has sqrt(2) 1e-4 m / 0.01 s of noise
  EXPECT_LT(error, 0.3 * speed);
}

TEST(RelocateTask, AScaledObjectKeepsItsMass) {
  const RelocateObject mug = relocate_primitive_mug(), small = scaled(mug, 0.9);
  EXPECT_EQ(small.mass, mug.mass);
  EXPECT_NEAR(small.start_height, 0.9 * mug.start_height, 1e-12);
  EXPECT_LT((small.inertia - 0.81 * mug.inertia).norm(), 1e-12);
  for (std::size_t i = 0; i < mug.primitives.size(); ++i) {
    const auto& part = small.primitives[i];
    const Eigen::Vector3d place = 0.9 * mug.primitives[i].T_object_part.translation();
    EXPECT_LT((part.half - 0.9 * mug.primitives[i].half).norm(), 1e-12);
    EXPECT_LT((part.T_object_part.translation() - place).norm(), 1e-12);
  }
  EXPECT_THROW(scaled(mug, 0), BadInput);
  const RelocateModel model(small);
  RelocateTask task(model);
  task.reset({{0.05, 0.1}, {0, 0, 0.2}});
  for (int i = 0; i < 60; ++i) task.step(rest());
  EXPECT_NEAR(task.positions()[32], 0.9 * 0.0312 + kMargin, 5e-4);
}

TEST(RelocateTask, RejectsBadInput) {
  EXPECT_THROW(relocate_solver("exact"), BadInput);
  EXPECT_THROW(RelocateModel(relocate_primitive_mug(), {RelocateSolver::fast, 0, 1}), BadInput);
  EXPECT_THROW(RelocateModel(relocate_primitive_mug(), {RelocateSolver::fast, 1, -1}), BadInput);
  EXPECT_THROW(relocate_mesh_object("brick", geometry::box_mesh({0.05, 0.04, 0.08}), 0), BadInput);
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(task.reset({{nan, 0}, {0, 0, 0}}), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
