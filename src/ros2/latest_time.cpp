// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/latest_time.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::uint64_t kMinSetBack = 100'000'000;  // ns, more than messages overtake each other by
constexpr int kInARow = 20;                         // messages

}  // namespace

TimeOrder LatestTime::take(std::uint64_t time) {
  if (time > time_ || time_ == 0) {
    *this = {};
    time_ = time;
    return TimeOrder::later;
  }
  if (time_ - time < kMinSetBack || time == early_) return TimeOrder::late;
  early_count_ = time > early_ ? early_count_ + 1 : 1;
  early_ = time;
  if (early_count_ < kInARow) return TimeOrder::late;
  *this = {};
  time_ = time;
  return TimeOrder::set_back;
}

}  // namespace palpate::ros2
