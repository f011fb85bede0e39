// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/regrasp.hpp"

#include <gtest/gtest.h>

#include "evaluation/mishap.hpp"

namespace palpate::skills {
namespace {

RegraspResult regrasp_through(evaluation::Mishap& mishap) {
  return regrasp(mishap.robot, mishap.task(), mishap.observer);
}

TEST(RegraspAfterALoss, LooksWhereTheObjectWasSensedLast) {
  evaluation::Mishap mishap;
  const RegraspResult result = regrasp_through(mishap);
  ASSERT_GE(result.rounds.size(), 2u);
  const RegraspRound &first = result.rounds[0], &second = result.rounds[1];
  ASSERT_TRUE(first.place);
  EXPECT_EQ(first.place->status, PlaceStatus::lost);
  EXPECT_GT(first.place->lost_at.norm(), 0);
  EXPECT_FALSE(first.pick.fallen);
  EXPECT_TRUE(second.pick.fallen);
  EXPECT_TRUE(second.pick.held);
  EXPECT_EQ(result.status, RegraspStatus::done);
  EXPECT_LT(mishap.off(*result.rounds.back().place), 0.03);
}

TEST(RegraspAfterALoss, EndsIfThatWasTheLastRound) {
  evaluation::Mishap mishap;
  mishap.options.place.regrasp.rounds = 1;
  const RegraspResult result = regrasp_through(mishap);
  EXPECT_EQ(result.rounds.size(), 1u);
  EXPECT_EQ(result.status, RegraspStatus::lost);
}

}  // namespace
}  // namespace palpate::skills
