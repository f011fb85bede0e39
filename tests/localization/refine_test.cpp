// SPDX-License-Identifier: Apache-2.0
#include "localization/search/refine.hpp"

#include <gtest/gtest.h>

namespace palpate::localization {
namespace {

/// Information of the prior that holds open directions, 1 rad and 50 mm, and `gained` besides.
RefinedPose with_information(const Vector6d& gained) {
  Vector6d prior;
  prior << 1, 1, 1, 400, 400, 400;
  RefinedPose refined;
  refined.information = (prior + gained).asDiagonal();
  return refined;
}

TEST(OpenDirections, AreThoseOfWhichTheEvidenceSaysLittle) {
  EXPECT_EQ(open_directions(with_information(Vector6d::Zero())), 6);
  Vector6d gained;
  gained << 1e3, 1e3, 1e3, 1e6, 1e6, 1e6;
  EXPECT_EQ(open_directions(with_information(gained)), 0);
  gained[2] = 0.1;
  EXPECT_EQ(open_directions(with_information(gained)), 1);
  gained[3] = 100;  // 100 mm
  EXPECT_EQ(open_directions(with_information(gained)), 2);
}

}  // namespace
}  // namespace palpate::localization
