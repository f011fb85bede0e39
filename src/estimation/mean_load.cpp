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
  for (const auto& reading : window) sum += reading.mount_force.z();
  return sum / static_cast<double>(window.size());
}

hand::MountPosition mean_mount(std::span<const hand::HandReading> readings) {
  hand::MountPosition mean;
  for (const auto& reading : readings) {
    mean.xyz += reading.mount.xyz / static_cast<double>(readings.size());
    mean.ypr += reading.mount.ypr / static_cast<double>(readings.size());
  }
  return mean;
}

hand::MountPosition mean_mount(const EventLog& log, std::size_t readings) {
  return mean_mount(last_of(log, readings));
}

}  // namespace palpate::estimation
