// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/touch_log.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::recording {
namespace {

using estimation::TouchEvent;

std::optional<TouchEvent> event_called(const char* text) {
  Event event;
  event.time = 1;
  event.text = text;
  return touch_event_of(event);
}

TEST(TouchEventOf, KnowsPresentAndFormerNames) {
  EXPECT_EQ(event_called("mark probed"), TouchEvent::probed);
  EXPECT_EQ(event_called("mark table_touched"), TouchEvent::table_touched);
  EXPECT_EQ(event_called("mark felt"), TouchEvent::height_probed);
  EXPECT_EQ(event_called("mark sweep"), TouchEvent::guarded_move);
  EXPECT_EQ(event_called("mark rolled"), TouchEvent::probed);
  EXPECT_EQ(event_called("fixture 1 2"), std::nullopt);
}

TEST(TouchEventOf, ReadsWhatTouchNoteWrites) {
  EXPECT_EQ(touch_note(TouchEvent::placed), "mark placed");
  for (std::size_t i = 0; i < estimation::kTouchEventNames.size(); ++i) {
    const auto event = static_cast<TouchEvent>(i);
    EXPECT_EQ(event_called(touch_note(event).c_str()), event);
  }
}

TEST(TouchEventOf, RefusesAnEventThatMeansNothing) {
  EXPECT_THROW(event_called("mark juggled"), BadInput);
}

}  // namespace
}  // namespace palpate::recording
