// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/probe_regrasp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/assets.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"

namespace palpate::skills {
namespace {

using std::numbers::pi;

/// A mug that stands with its handle to one side or to the other.
struct TwoMugs {
  TwoMugs() : object(geometry::load_known_object("mug")) {
    simulation::World world(object.object(), {}, 1);
    tool = regrasp_tool(world.hand_model());
    options.plan.press = 5;
    for (const double yaw : {0.0, pi}) {
      localization::Mode mode;
      mode.T_frame_object = standing(yaw);
      mode.weight = 0.5;
      mode.covariance = Matrix6d::Identity() * 1e-8;
      posterior.modes.push_back(mode);
    }
  }
  Eigen::Isometry3d standing(double yaw) const {
    const auto& stable_poses = object.object().stable_poses;
    const auto upright =
        std::max_element(stable_poses.begin(), stable_poses.end(),
                         [](const auto& a, const auto& b) { return a.height < b.height; });
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * upright->R_table_object;
    T.translation().z() = upright->height;
    return T;
  }
  std::optional<InformativeGrasp> choose() const {
    return most_informative_grasp(object, posterior, tool, options);
  }
  geometry::ObjectModel object;
  GraspTool tool;
  InformativeGraspOptions options;
  localization::Posterior posterior;
};

TEST(MostInformativeGrasp, HoldsEitherWayAndTouchesTheHandle) {
  const TwoMugs mugs;
  const auto grasp = mugs.choose();
  ASSERT_TRUE(grasp);
  EXPECT_GT(grasp->expected_gain.information, 0.5);  // of ln 2
  EXPECT_LE(grasp->expected_gain.information, std::log(2.0) + 1e-9);
  for (const auto& mode : mugs.posterior.modes) {
    const auto closed = grasping::close_virtually(mugs.object, mode.T_frame_object, mugs.tool.path,
                                                  grasp->plan.mount, mugs.options.plan);
    ASSERT_TRUE(closed);
    EXPECT_LT(closed->cost, mugs.options.worst_cost);
  }
}

TEST(MostInformativeGrasp, HasNoInformationOnPosesThatAreOne) {
  TwoMugs mugs;
  mugs.posterior.modes[1].T_frame_object = mugs.posterior.modes[0].T_frame_object;
  const auto grasp = mugs.choose();
  ASSERT_TRUE(grasp);
  EXPECT_NEAR(grasp->expected_gain.information, 0, 1e-9);
}

TEST(MostInformativeGrasp, HasNoInformationOnPosesThatClosingTurnsIntoOneAnother) {
  TwoMugs mugs;
  mugs.posterior.modes[1].T_frame_object = mugs.standing(0.15);
  ASSERT_TRUE(mugs.choose());
  EXPECT_EQ(mugs.choose()->expected_gain.information, 0);
  mugs.posterior.modes[1].T_frame_object = mugs.standing(0.4);
  ASSERT_TRUE(mugs.choose());
  EXPECT_GT(mugs.choose()->expected_gain.information, 0.05);
}

TEST(MostInformativeGrasp, KeepsAwayFromTriedSidesAndFromNoPoseAtAll) {
  TwoMugs mugs;
  for (int i = 0; i < 12; ++i) mugs.options.avoid.push_back(i * pi / 6);
  EXPECT_FALSE(mugs.choose());
  mugs.options.avoid.clear();
  mugs.posterior.modes.clear();
  EXPECT_FALSE(mugs.choose());
}

}  // namespace
}  // namespace palpate::skills
