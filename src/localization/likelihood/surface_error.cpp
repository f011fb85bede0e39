// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/surface_error.hpp"

#include <cmath>

namespace palpate::localization {
namespace {

constexpr double kWaveLength = 0.006;  // m over which errors of a scan's surface change

}  // namespace

Evidence with_surface_error(Evidence evidence) {
  const double sigma = evidence.surface_sigma;
  for (tactile::Contact& contact : evidence.contacts) {
    contact.point_sigma = std::hypot(contact.point_sigma, sigma);
    contact.normal_sigma = std::hypot(contact.normal_sigma, sigma / kWaveLength);
  }
  if (evidence.table) {
    evidence.table->surface_sigma = std::hypot(evidence.table->surface_sigma, sigma);
  }
  evidence.surface_sigma = 0;
  return evidence;
}

}  // namespace palpate::localization
