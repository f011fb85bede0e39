// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/drawn_task.hpp"

#include <gtest/gtest.h>

#include <string>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::relocate {
namespace {

TaskOptions fast(const std::string& object) {
  TaskOptions task;
  task.object = object;
  task.solver = "fast";
  return task;
}

/// A task at a start, and how it is drawn.
struct Scene {
  explicit Scene(const std::string& object)
      : model(make_model(fast(object))), run(model), drawn(fast(object), model) {
    run.reset(start);
  }
  const RelocateStart start{.object = {-0.05, 0.02}, .target = {0.1, 0.05, 0.25}};
  const RelocateModel model;
  RelocateTask run;
  DrawnTask drawn;
};

TEST(DrawnTask, EverythingIsWhereTheTaskHasIt) {
  Scene scene("box");
  const auto state = scene.drawn.at(scene.run.positions(), scene.start.target);
  EXPECT_NEAR((state.T_world_object.translation().head<2>() - scene.start.object).norm(), 0, 1e-9);
  const auto links = hand::forward_kinematics(scene.drawn.hand(), state.joints);
  const Eigen::Isometry3d palm =
      state.mount.pose() * links[static_cast<std::size_t>(scene.drawn.hand().palm)];
  EXPECT_NEAR((palm.translation() - Eigen::Vector3d(0, -0.27, 0.20)).norm(), 0, 2e-3);
  ASSERT_EQ(state.ghosts.size(), 1u);
  EXPECT_EQ(state.ghosts[0].T_world_object.translation(), scene.start.target);
  EXPECT_EQ(state.ghosts[0].T_world_object.linear(), state.T_world_object.linear());
  EXPECT_TRUE(scene.drawn.at(scene.run.positions()).ghosts.empty());
}

TEST(DrawnTask, ThePictureShowsTheTargetAndTheHand) {
  if (!simulation::working_render_backend()) GTEST_SKIP() << "neither EGL nor OSMesa works here";
  Scene scene("box");
  simulation::Renderer renderer(scene.drawn.hand(), scene.drawn.object(), 240, 180);
  const auto picture = [&](const Eigen::Vector3d& target) {
    return renderer.render(scene.drawn.at(scene.run.positions(), target), task_camera()).rgb;
  };
  const auto first = picture(scene.start.target);
  EXPECT_EQ(first, picture(scene.start.target));
  EXPECT_NE(first, picture({-0.1, 0.1, 0.3}));
  RelocateAction up = RelocateAction::Zero();
  up[2] = 1;
  for (int i = 0; i < 20; ++i) scene.run.step(up);
  EXPECT_NE(first, picture(scene.start.target));
}

TEST(DrawnTask, RefusesAnUnknownObject) {
  const Scene scene("box");
  EXPECT_THROW(DrawnTask(fast("nothing.stl"), scene.model), BadInput);
}

}  // namespace
}  // namespace palpate::relocate
