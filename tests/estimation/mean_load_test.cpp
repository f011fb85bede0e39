// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/mean_load.hpp"

#include <gtest/gtest.h>

namespace palpate::estimation {
namespace {

/// Readings 1, 2, ... of which each carries its number in N, and is its number in mm from the
/// origin.
EventLog counted(int readings) {
  EventLog log;
  for (int i = 1; i <= readings; ++i) {
    hand::HandReading reading;
    reading.mount_force.z() = i;
    reading.mount.xyz.x() = 0.001 * i;
    reading.mount.ypr.z() = 0.01 * i;
    log.readings.push_back(reading);
  }
  return log;
}

TEST(MeanLoad, IsThatOfTheLastReadings) {
  const EventLog log = counted(30);
  EXPECT_NEAR(mean_load(log, 3), 29, 1e-12);
  EXPECT_NEAR(mean_load(log), 20.5, 1e-12);
  EXPECT_NEAR(mean_load(log, 100), 15.5, 1e-12);
}

TEST(MeanMount, IsThatOfTheLastReadings) {
  const EventLog log = counted(30);
  EXPECT_NEAR(mean_mount(log, 3).xyz.x(), 0.029, 1e-12);
  EXPECT_NEAR(mean_mount(log, 3).ypr.z(), 0.29, 1e-12);
  EXPECT_NEAR(mean_mount(log, 100).xyz.x(), 0.0155, 1e-12);
  EXPECT_NEAR(mean_mount({log.readings.data(), 2}).xyz.x(), 0.0015, 1e-12);
}

}  // namespace
}  // namespace palpate::estimation
