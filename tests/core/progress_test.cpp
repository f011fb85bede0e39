// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/progress.hpp"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(ProgressBar, HalfWay) {
  EXPECT_EQ(progress_bar(15, 30, 75),
            " 50% [===============               ] 15/30  1:15 passed, 1:15 left");
}

TEST(ProgressBar, StartKnowsNoTimeLeft) {
  EXPECT_EQ(progress_bar(0, 30, 2),
            "  0% [                              ] 0/30  0:02 passed, ? left");
}

TEST(ProgressBar, End) {
  EXPECT_EQ(progress_bar(30, 30, 3725),
            "100% [==============================] 30/30  1:02:05 passed, 0:00 left");
}

TEST(ProgressBar, NotFullBeforeTheEnd) {
  const std::string bar = progress_bar(999, 1000, 1);
  EXPECT_EQ(bar.substr(0, 4), " 99%");
  EXPECT_NE(bar.find("= ]"), std::string::npos);
}

TEST(ProgressBar, NothingToDoIsDone) { EXPECT_EQ(progress_bar(0, 0, 0).substr(0, 4), "100%"); }

TEST(ProgressBar, KeepsItsLength) {
  for (std::size_t done = 10; done < 99; ++done) {
    EXPECT_EQ(progress_bar(done, 99, 60).find(']'), 36u);
  }
}

}  // namespace
}  // namespace palpate
