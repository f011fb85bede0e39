// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/surface_error.hpp"

#include <cmath>

#include "palpate/geometry/objects/resting_slack.hpp"

namespace palpate::localization {

Evidence with_surface_error(Evidence evidence) {
  const double sigma = evidence.surface_sigma;
  for (tactile::Contact& contact : evidence.contacts) {
    contact.point_sigma = std::hypot(contact.point_sigma, sigma);
    contact.normal_sigma = std::hypot(contact.normal_sigma, sigma / geometry::kSurfaceErrorLength);
  }
  for (PlaneContact& plane : evidence.planes) plane.sigma = std::hypot(plane.sigma, sigma);
  if (evidence.table) {
    evidence.table->surface_sigma = std::hypot(evidence.table->surface_sigma, sigma);
  }
  evidence.surface_sigma = 0;
  return evidence;
}

}  // namespace palpate::localization
