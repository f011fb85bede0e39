// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/grip_watch.hpp"

#include <algorithm>
#include <numeric>
#include <span>

#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/tip_forces.hpp"

namespace palpate::skills {
namespace {

constexpr std::size_t kBefore = 15;  // readings, averaged against noise
constexpr std::size_t kNow = 3;
constexpr double kLeft = 0.8;         // of the force: less is lost
constexpr double kMostOnTable = 0.4;  // of the force, that may press the object on the table
constexpr double kFirm = 0.5;         // N, that distinguish a loss from noise

double press_of(const hand::HandReading& reading) {
  double sum = 0;
  for (int finger = 0; finger < std::ssize(reading.contacts); ++finger) {
    sum += hand::tip_force(reading, finger);
  }
  return sum;
}

}  // namespace

GripWatch::GripWatch(const Executor& robot) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const auto window = readings.last(std::min(readings.size(), kBefore));
  const double sum = std::accumulate(
      window.begin(), window.end(), 0.0,
      [](double before, const auto& reading) { return before + press_of(reading); });
  const double pressed = sum / static_cast<double>(window.size());
  const double onto_table = std::max(0.0, -estimation::mean_load(robot.log(), kBefore));
  pressed_ = pressed - std::min(onto_table, kMostOnTable * pressed);
}

bool GripWatch::update(const hand::HandReading& reading) {
  pressing_.push_back(press_of(reading));
  if (pressing_.size() > kNow) pressing_.pop_front();
  const double now =
      std::accumulate(pressing_.begin(), pressing_.end(), 0.0) / static_cast<double>(kNow);
  return pressing_.size() == kNow && pressed_ > kFirm && now < kLeft * pressed_;
}

}  // namespace palpate::skills
