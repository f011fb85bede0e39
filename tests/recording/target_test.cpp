// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/target.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::recording {
namespace {

constexpr const char* kFirst = "target 1 0 0 0.1 0 1 0 0.2 0 0 1 0.3 0 0 0 1";
constexpr const char* kSecond = "target 0 -1 0 0.4 1 0 0 0 0 0 1 0 0 0 0 1";

std::vector<Event> events() {
  return {{1, EventKind::note, "plan-goal", kFirst},
          {2, EventKind::begin, "transport", kSecond},
          {3, EventKind::note, "replan-goal", kSecond},
          {4, EventKind::note, "replan-goal", "target 1 2 3"}};
}

TEST(Target, IsTheLastThatIsKnownAtATime) {
  EXPECT_FALSE(target_at(events(), 0.9));
  const auto first = target_at(events(), 2.9), second = target_at(events(), 9);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(second->translation(), Eigen::Vector3d(0.4, 0, 0));
  EXPECT_EQ(second->linear().col(0), Eigen::Vector3d::UnitY());
}

TEST(Target, RefusesWhatIsNoPose) {
  const std::vector<Event> scaled = {
      {0, EventKind::note, "", "target 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1"}};
  EXPECT_THROW(target_at(scaled, 1), BadInput);
}

}  // namespace
}  // namespace palpate::recording
