// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/mean_load.hpp"

#include <algorithm>

namespace palpate::estimation {
namespace {

std::span<const hand::HandReading> last_of(const EventLog& log, std::size_t readings) {
  const std::span<const hand::HandReading> all(log.readings);
  return all.last(std::min(all.size(), readings));
}

}  // namespace

double mean_load(const EventLog& log, std::size_t readings) {
  double sum = 0;
  const auto window = last_of(log, readings);
  for (const auto& reading : window) sum += reading.base_force.z();
  return sum / static_cast<double>(window.size());
}

hand::BasePosition mean_base(std::span<const hand::HandReading> readings) {
  hand::BasePosition mean;
  for (const auto& reading : readings) {
    mean.xyz += reading.base.xyz / static_cast<double>(readings.size());
    mean.ypr += reading.base.ypr / static_cast<double>(readings.size());
  }
  return mean;
}

hand::BasePosition mean_base(const EventLog& log, std::size_t readings) {
  return mean_base(last_of(log, readings));
}

}  // namespace palpate::estimation
