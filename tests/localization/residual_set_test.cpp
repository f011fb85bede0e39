// SPDX-License-Identifier: Apache-2.0
#include "localization/search/residual_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "localization/searches.hpp"
#include "palpate/core/random.hpp"

namespace palpate::localization {
namespace {

const PoseFamily::Symmetries kNone = {Eigen::Quaterniond::Identity()};

/// Places 10 cm apart, so many poses at each.
std::vector<PosePoint> places(const std::vector<int>& counts) {
  std::vector<PosePoint> poses;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const PosePoint place(Eigen::Quaterniond::Identity(), {0.1 * static_cast<double>(i), 0, 0});
    poses.insert(poses.end(), static_cast<std::size_t>(counts[i]), place);
  }
  return poses;
}

std::vector<int> places_of(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<int> result;
  for (const auto& T : poses) {
    result.push_back(static_cast<int>(std::lround(T.translation().x() / 0.1)));
  }
  return result;
}

Mode mode_at(double x) {
  Mode mode;
  mode.T_frame_object.translation().x() = x;
  return mode;
}

TEST(UnseenShare, IsOfThePosesFarFromAllOthers) {
  EXPECT_NEAR(unseen_share(places({3, 0, 1}), places({1, 1, 0}), kNone), 0.25, 1e-12);
  EXPECT_EQ(unseen_share(places({3, 2}), places({1, 1}), kNone), 0);
  EXPECT_EQ(unseen_share({}, places({1}), kNone), 0);
}

TEST(ResidualSet, IsEmptyWhereTheModesHoldEnough) {
  EXPECT_TRUE(residual_set({mode_at(0)}, places({90, 10}), places({95, 5}), kNone).poses.empty());
}

TEST(ResidualSet, HoldTheRestOfTheOtherPopulationUpToTheCredibleShare) {
  const auto rest =
      residual_set({mode_at(0)}, places({50, 10, 30, 8, 2}), places({50, 12, 30, 4, 4}), kNone);
  EXPECT_EQ(places_of(rest.poses), (std::vector<int>{2, 1, 3}));  // 30 and 12 and 4 besides 50
  EXPECT_EQ(rest.credible_mass, 0.95);
}

TEST(ResidualSet, TheLastBallMayCompleteIt) {
  const auto rest = residual_set({mode_at(0)}, places({60, 40}), places({60, 37, 3}), kNone);
  EXPECT_EQ(places_of(rest.poses), (std::vector<int>{1}));
  EXPECT_EQ(rest.credible_mass, 0.95);
}

TEST(ResidualSet, AreAllThereAreWhereTheFirstPopulationMissedTooMany) {
  const auto rest = residual_set({mode_at(0)}, places({60, 40}), places({60, 20, 0, 5, 15}), kNone);
  EXPECT_EQ(places_of(rest.poses), (std::vector<int>{1, 4, 3}));
  EXPECT_NEAR(rest.credible_mass, 0.8, 1e-12);  // what the poses of the first hold
}

TEST(ResidualSet, HoldTheTruthAsOftenAsTheySay) {
  SceneOptions options;
  options.contacts = 5;
  LocalizerOptions search;
  search.modes = 1;  // all else is rest
  int held = 0, spread = 0;
  constexpr int kScenes = 40;
  for (std::uint64_t i = 0; i < kScenes; ++i) {
    const std::string name = i % 2 == 0 ? "box" : "bunny";
    const Scene scene = scene_of(name, options, i);
    const Posterior posterior = localize(model_of(name), scene.evidence, RandomStream(i), search);
    held += truth_in_credible_set(posterior, scene.truth, model_of(name).object().symmetries);
    spread += !posterior.residual_set.empty();
  }
  EXPECT_GE(held, 0.95 * kScenes - 2 * std::sqrt(kScenes * 0.95 * 0.05));
  EXPECT_GE(spread, kScenes / 4);  // else nothing was tried
}

}  // namespace
}  // namespace palpate::localization
