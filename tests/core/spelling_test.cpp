// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/spelling.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace palpate {
namespace {

TEST(Spelling, DistanceIsTheShareOfLettersThatDiffer) {
  EXPECT_EQ(spelling_distance("", ""), 0);
  EXPECT_EQ(spelling_distance("mug", "mug"), 0);
  EXPECT_EQ(spelling_distance("", "mug"), 1);
  EXPECT_DOUBLE_EQ(spelling_distance("mugg", "mug"), 1.0 / 4);
  EXPECT_DOUBLE_EQ(spelling_distance("kitten", "sitting"), 3.0 / 7);
  EXPECT_DOUBLE_EQ(spelling_distance("verison", "version"), 1.0 / 7);  // two letters exchanged
  EXPECT_DOUBLE_EQ(spelling_distance("ba", "ab"), 1.0 / 2);
}

TEST(Spelling, DistanceIsSymmetric) {
  EXPECT_EQ(spelling_distance("lift.way", "lift.wya"), spelling_distance("lift.wya", "lift.way"));
}

TEST(Spelling, OnlyWhatDiffersByAThirdOfItsLettersIsSuggested) {
  const std::vector<std::string> names = {"pick", "register"};
  EXPECT_EQ(did_you_mean("pikc", names), "; did you mean 'pick'?");
  EXPECT_EQ(did_you_mean("rgister", names), "; did you mean 'register'?");
  EXPECT_EQ(did_you_mean("package", names), "");
  EXPECT_EQ(did_you_mean("lock", names), "");
}

}  // namespace
}  // namespace palpate
