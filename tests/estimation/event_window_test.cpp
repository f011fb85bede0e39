// SPDX-License-Identifier: Apache-2.0
#include "estimation/event_window.hpp"

#include <gtest/gtest.h>

namespace palpate::estimation {
namespace {

EventLog log_of(std::size_t readings) {
  EventLog log;
  log.readings.resize(readings);
  return log;
}

TEST(EventWindow, EndsAtTheEventAndIsAsLongAsTheHandStoodStill) {
  const EventLog log = log_of(200);
  EstimationOptions options;
  options.window = 0.4;
  const auto length = [&](TouchEvent event) {
    const auto window = event_window(log, event, 150, options);
    EXPECT_EQ(&window.back(), &log.readings[150]);
    return window.size();
  };
  EXPECT_EQ(length(TouchEvent::touched), 10u);
  EXPECT_EQ(length(TouchEvent::closed), 15u);
  EXPECT_EQ(length(TouchEvent::probed), 15u);
  EXPECT_EQ(length(TouchEvent::held), 40u);
}

TEST(EventWindow, BeginsWithTheLogAtTheEarliest) {
  const EventLog log = log_of(200);
  EXPECT_EQ(event_window(log, TouchEvent::closed, 4, {}).size(), 5u);
  EXPECT_EQ(event_window(log, TouchEvent::held, 0, {}).size(), 1u);
}

}  // namespace
}  // namespace palpate::estimation
