// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "recording/schema.hpp"

namespace palpate::recording {
namespace {

constexpr std::int16_t kMissing = -1;

std::int16_t to_count(double value) {
  if (std::isnan(value)) return kMissing;
  if (!(std::abs(value) <= std::numeric_limits<std::int16_t>::max())) {
    throw BadInput(fmt::format("a BioTac's channel has {} counts, beyond 16 bits", value));
  }
  return static_cast<std::int16_t>(std::lround(value));
}

double from_count(std::int16_t count) {
  return count == kMissing ? std::numeric_limits<double>::quiet_NaN() : count;
}

}  // namespace

void append_biotacs(const hand::HandReading& reading, std::vector<std::int16_t>& counts) {
  if (reading.biotacs.size() != reading.contacts.size()) {
    throw BadInput(fmt::format("the frame at {} s has the channels of {} BioTacs, not {}",
                               reading.time, reading.biotacs.size(), reading.contacts.size()));
  }
  for (const auto& biotac : reading.biotacs) {
    for (const double value : {biotac.pdc, biotac.tdc, biotac.tac}) {
      counts.push_back(to_count(value));
    }
    for (const double value : biotac.electrodes) counts.push_back(to_count(value));
    for (const double value : biotac.pac) counts.push_back(to_count(value));
    counts.push_back(biotac.pac_interpolated ? 1 : 0);
  }
}

void set_biotacs(const std::int16_t* counts, hand::HandReading& reading) {
  for (std::size_t finger = 0; finger < reading.contacts.size(); ++finger) {
    hand::BiotacReading biotac;
    biotac.time = reading.time;
    biotac.pdc = from_count(*counts++);
    biotac.tdc = from_count(*counts++);
    biotac.tac = from_count(*counts++);
    for (double& value : biotac.electrodes) value = from_count(*counts++);
    for (double& value : biotac.pac) value = from_count(*counts++);
    biotac.pac_interpolated = *counts++ != 0;
    reading.biotacs.push_back(biotac);
  }
}

}  // namespace palpate::recording
