// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/extents.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/objects/object_model.hpp"

namespace palpate::skills {
namespace {

/// 50 x 94 x 175 mm: it lies, stands on its side, or stands up.
const geometry::ObjectModel& box() {
  static const geometry::ObjectModel model(geometry::load_known_object("box"));
  return model;
}

const geometry::ObjectModel& mug() {
  static const geometry::ObjectModel model(geometry::load_known_object("mug"));
  return model;
}

TEST(Extents, TheTallestIsThatOfAnyCandidate) {
  EXPECT_NEAR(tallest({&box()}), 0.175, 1e-6);
  EXPECT_LT(tallest({&mug()}), 0.13);
  EXPECT_NEAR(tallest({&mug(), &box()}), 0.175, 1e-6);
}

TEST(Extents, WhatIsProbedBesideItsTopIsTaller) {
  EXPECT_NEAR(likely_top({&box()}, 0.098), 0.098, 1e-6) << "probed a little too high";
  EXPECT_NEAR(likely_top({&box()}, 0.030), 0.050, 1e-6);
  EXPECT_NEAR(likely_top({&box()}, 0.075), 0.094, 1e-6);
  EXPECT_NEAR(likely_top({&box()}, 0.190), 0.190, 1e-6) << "taller than any stable pose";
}

TEST(Extents, AnObjectThatStandsUpReachesLessFar) {
  const double lying = likely_reach({&box()}, 0.05), standing = likely_reach({&box()}, 0.17);
  EXPECT_NEAR(lying, 0.5 * std::hypot(0.094, 0.175), 1e-3);
  EXPECT_NEAR(standing, 0.5 * std::hypot(0.050, 0.094), 1e-3);
  EXPECT_EQ(likely_reach({&box()}, 0.5), lying) << "as tall as no stable pose: any";
}

}  // namespace
}  // namespace palpate::skills
