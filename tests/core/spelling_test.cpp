// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/spelling.hpp"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Spelling, DistanceIsTheShareOfLettersThatDiffer) {
  EXPECT_EQ(spelling_distance("", ""), 0);
  EXPECT_EQ(spelling_distance("mug", "mug"), 0);
  EXPECT_EQ(spelling_distance("", "mug"), 1);
  EXPECT_DOUBLE_EQ(spelling_distance("mugg", "mug"), 1.0 / 4);
  EXPECT_DOUBLE_EQ(spelling_distance("kitten", "sitting"), 3.0 / 7);
}

TEST(Spelling, DistanceIsSymmetric) {
  EXPECT_EQ(spelling_distance("lift.way", "lift.wya"), spelling_distance("lift.wya", "lift.way"));
}

}  // namespace
}  // namespace palpate
