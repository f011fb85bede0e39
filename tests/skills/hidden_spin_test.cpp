// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/hidden_spin.hpp"

#include <gtest/gtest.h>

namespace palpate::skills {
namespace {

constexpr double kSurfaceSigma = 0.0005;  // m

/// One pose, elsewhere than at the origin, that may be rotated about its z axis by +- `extent`.
localization::Posterior spinning(double extent) {
  localization::Mode mode;
  mode.T_frame_object =
      Eigen::Translation3d(0.1, -0.2, 0.3) * Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX());
  mode.weight = 0.8;
  mode.free_axis = {mode.T_frame_object.translation(),
                    mode.T_frame_object.linear() * Eigen::Vector3d::UnitZ(), extent};
  localization::Posterior posterior;
  posterior.modes.push_back(mode);
  return posterior;
}

double probability(const geometry::ObjectModel& object, const localization::Posterior& posterior) {
  return probability_but_for_hidden_spin(object, posterior, kSurfaceSigma);
}

/// It is 96 mm wide and 66 mm deep.
TEST(HiddenSpin, OfABottleCountsIfTheArcIsWide) {
  const geometry::ObjectModel bottle(geometry::load_known_object("bottle"));
  EXPECT_LT(localization::best_probability(spinning(0.1)), 0.75);
  EXPECT_EQ(probability(bottle, spinning(0.1)), 0.8);
  EXPECT_EQ(probability(bottle, spinning(1)), localization::best_probability(spinning(1)));
}

/// Its wall is round, but its handle shows.
TEST(HiddenSpin, OfAMugCounts) {
  const geometry::ObjectModel mug(geometry::load_known_object("mug"));
  const auto posterior = spinning(1);
  EXPECT_EQ(probability(mug, posterior), localization::best_probability(posterior));
}

TEST(HiddenSpin, IsNothingWithoutAFreeAxis) {
  const geometry::ObjectModel bottle(geometry::load_known_object("bottle"));
  auto posterior = spinning(1);
  posterior.modes.front().free_axis.reset();
  EXPECT_EQ(probability(bottle, posterior), 0.8);
  EXPECT_EQ(probability(bottle, {}), 0);
}

}  // namespace
}  // namespace palpate::skills
