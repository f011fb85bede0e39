// SPDX-License-Identifier: Apache-2.0
#include "localization/search/proposal.hpp"

#include <gtest/gtest.h>

#include "localization/likelihood/table_term.hpp"
#include "localization/scenes.hpp"
#include "localization/search/moves.hpp"

namespace palpate::localization {
namespace {

TEST(TableTerm, DrawsFromTheDensityItEvaluates) {
  const geometry::ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.table = true;
  const Scene scene = make_scene(model, options, RandomStream(1));
  TableSupport table = *scene.evidence.table;
  table.stable_pose_weights.assign(model.object().stable_poses.size(), 0);
  table.stable_pose_weights[1] = 2;
  const TableTerm term(model, table);
  RandomStream random(2);
  constexpr int kDraws = 20000;
  double energy = 0, height = 0, spread_x = 0;
  for (int i = 0; i < kDraws; ++i) {
    const SearchPose pose = term.draw(random);
    const Eigen::Vector3d at = table.T_frame_table.inverse() * pose.t.cast<double>();
    energy += static_cast<double>(term.energy(pose, kNoBound)) / kDraws;
    height += at.z() / kDraws;
    spread_x += at.x() * at.x() / kDraws;
  }
  // Half a unit each: two tilts, the height, and the edges where they are (5 % of x and y each).
  const double edge = table.edge_sigma * std::sqrt(2 * M_PI);
  EXPECT_NEAR(energy, 1.5 + edge / (2 * table.half_width + edge), 0.03);
  EXPECT_NEAR(height, model.object().stable_poses[1].height, 0.0001);
  EXPECT_NEAR(std::sqrt(spread_x), table.half_width / std::sqrt(3), 0.1 * table.half_width);
}

TEST(TableTerm, LargeLeansAreAsProbableAsStated) {
  const geometry::ObjectModel& model = model_of("bottle");  // it lies, and rolls
  TableSupport table;
  table.T_frame_table = Eigen::Isometry3d::Identity();
  table.stable_pose_weights.assign(model.object().stable_poses.size(), 0);
  table.stable_pose_weights[0] = 1;
  table.surface_sigma = 0.001;
  table.centroid_sigma = 0.005;
  double expected = 1.5;  // half a unit for each lean and the height, and the leans' widths
  for (const int i : {0, 1}) {
    const double lean = model.resting_slack()[0].lean(i, table.surface_sigma, table.centroid_sigma);
    EXPECT_GT(lean, i == 0 ? 0.2 : 0.0);
    expected += std::log(std::hypot(1, lean / table.tilt_sigma));
  }
  const double edge = table.edge_sigma * std::sqrt(2 * M_PI);
  expected += edge / (2 * table.half_width + edge);
  const TableTerm term(model, table);
  RandomStream random(3);
  constexpr int kDraws = 20000;
  double energy = 0;
  for (int i = 0; i < kDraws; ++i) {
    energy += static_cast<double>(term.energy(term.draw(random), kNoBound)) / kDraws;
  }
  EXPECT_NEAR(energy, expected, 0.05);
}

TEST(TableTerm, AMugRollsOffItsHandleAndNotOverIt) {
  const geometry::ObjectModel& model = model_of("mug");
  const auto& stable_poses = model.object().stable_poses;
  std::size_t lying = 0;
  while (lying < stable_poses.size() && model.resting_slack()[lying].lean(0, 0, 0.003) < 0.1)
    ++lying;
  ASSERT_LT(lying, stable_poses.size());
  TableSupport table;
  table.T_frame_table = Eigen::Isometry3d::Identity();
  table.stable_pose_weights.assign(stable_poses.size(), 0);
  table.stable_pose_weights[lying] = 1;
  table.centroid_sigma = 0.003;
  const TableTerm term(model, table);
  const Eigen::Vector3d up = stable_poses[lying].R_table_object.row(2).transpose();
  const Eigen::Vector3d direction = model.resting_slack()[lying].directions()[0];
  const double off_handle = model.resting_slack()[lying].lean_to(1, 0, 0, 0.003) > 0.1 ? 1 : -1;

  // By the energy: the density over leans off the handle (positive) and over it.
  const auto density = [&](double lean) {
    const Eigen::AngleAxisd turn(-off_handle * lean, up.cross(direction));
    SearchPose pose;
    pose.R = (stable_poses[lying].R_table_object * turn.toRotationMatrix()).cast<float>();
    pose.t = {0, 0, static_cast<float>(stable_poses[lying].height)};
    return std::exp(-static_cast<double>(term.energy(pose, kNoBound)));
  };
  constexpr double kStep = 0.002, kFar = 0.2;
  double all = 0, off = 0, over = 0;
  for (double lean = -1.5; lean < 1.5; lean += kStep) {
    all += density(lean);
    if (lean > kFar) off += density(lean);
    if (lean < -kFar) over += density(lean);
  }
  EXPECT_GT(off / all, 0.15);
  EXPECT_LT(over / all, 1e-6);

  RandomStream random(5);
  constexpr int kDraws = 20000;
  int drawn_off = 0, drawn_over = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d table_up = term.draw(random).R.row(2).transpose().cast<double>();
    const double lean = off_handle * std::asin(std::clamp(table_up.dot(direction), -1.0, 1.0));
    drawn_off += lean > kFar;
    drawn_over += lean < -kFar;
  }
  EXPECT_NEAR(drawn_off / static_cast<double>(kDraws), off / all, 0.02);
  EXPECT_EQ(drawn_over, 0);
}

TEST(AnchorProposal, PutsTheSurfaceAtAContact) {
  const geometry::ObjectModel& model = model_of("bracket");
  const Scene scene = make_scene(model, {}, RandomStream(3));
  const auto proposal = make_proposal(model, scene.evidence, {});
  RandomStream random(4);
  int near = 0;
  for (int i = 0; i < 200; ++i) {
    const SearchPose pose = proposal->draw(random);
    EXPECT_NEAR((pose.R * pose.R.transpose() - Eigen::Matrix3f::Identity()).norm(), 0, 1e-4);
    double least = 1;
    for (const auto& contact : scene.evidence.contacts) {
      const Eigen::Vector3f p = pose.R.transpose() * (contact.p.cast<float>() - pose.t);
      least = std::min<double>(least, std::abs(model.field().distance(p)));
    }
    near += least < 0.003;
  }
  EXPECT_GT(near, 190);
}

TEST(Moves, AreRigidAndStaySmallWhenNarrow) {
  const geometry::ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.table = true;
  const Scene scene = make_scene(model, options, RandomStream(5));
  const Moves moves(model, scene.evidence);
  RandomStream random(6);
  SearchPose pose{scene.truth.linear().cast<float>(), scene.truth.translation().cast<float>()};
  int small = 0;
  for (int i = 0; i < 1000; ++i) {
    const SearchPose to = moves.draw(pose, 0.1, random);
    EXPECT_NEAR((to.R * to.R.transpose() - Eigen::Matrix3f::Identity()).norm(), 0, 1e-5);
    small += (to.t - pose.t).norm() < 0.001 && (to.R - pose.R).norm() < 0.05;
  }
  EXPECT_GT(small, 500);
  EXPECT_LT(small, 1000);  // the heavy-tailed ones
}

}  // namespace
}  // namespace palpate::localization
