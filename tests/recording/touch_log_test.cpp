// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/touch_log.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::recording {
namespace {

using estimation::TouchEvent;

std::optional<TouchEvent> mark_called(const char* text) {
  Event event;
  event.time = 1;
  event.text = text;
  return mark_of(event);
}

TEST(MarkOf, KnowsPresentAndFormerNames) {
  EXPECT_EQ(mark_called("mark probed"), TouchEvent::probed);
  EXPECT_EQ(mark_called("mark table_touched"), TouchEvent::table_touched);
  EXPECT_EQ(mark_called("mark felt"), TouchEvent::height_probed);
  EXPECT_EQ(mark_called("mark sweep"), TouchEvent::guarded_move);
  EXPECT_EQ(mark_called("mark rolled"), TouchEvent::probed);
  EXPECT_EQ(mark_called("fixture 1 2"), std::nullopt);
}

TEST(MarkOf, RefusesAMarkThatMeansNothing) { EXPECT_THROW(mark_called("mark juggled"), BadInput); }

}  // namespace
}  // namespace palpate::recording
