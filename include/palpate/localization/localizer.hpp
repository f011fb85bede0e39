// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "palpate/core/random.hpp"
#include "palpate/geometry/distance_field.hpp"
#include "palpate/geometry/known_object.hpp"
#include "palpate/localization/evidence.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

/// An object prepared for the search: distance field and surface samples. Shared by threads.
class ObjectModel {
 public:
  explicit ObjectModel(geometry::KnownObject object);
  const geometry::KnownObject& object() const { return object_; }
  const geometry::DistanceField& field() const { return field_; }
  struct SurfacePoint {
    Eigen::Vector3f p, n;
  };
  const std::vector<SurfacePoint>& surface() const { return surface_; }
  double area() const { return area_; }

 private:
  geometry::KnownObject object_;
  double area_;
  geometry::DistanceField field_;
  std::vector<SurfacePoint> surface_;
};

struct LocalizerOptions {
  int proposals = 60000;     ///< poses screened
  int particles = 1200;      ///< carried through the tempering
  int moves = 8;             ///< Metropolis moves a particle and level
  double first_scale = 3.0;  ///< noise scale at which the search starts
  double contact_offset =
      0.003;  ///< distance outside the surface at which contacts are compared, m

  template <class Visitor>
  void visit(Visitor&& v) {
    v("proposals", proposals, 1000, 10000000, "poses screened");
    v("particles", particles, 50, 1000000, "poses carried through the tempering");
    v("moves", moves, 1, 1000, "Metropolis moves a particle and level");
    v("first_scale", first_scale, 1.0, 20.0, "noise scale at which the search starts");
    v("contact_offset", contact_offset, 0.0, 0.02, "m outside the surface where contacts compare");
  }
};

/// Posterior of the object's pose in the evidence's frame, by tempered sequential Monte Carlo.
///
/// Without a table or a prior at least one contact is needed, else the status is no_pose.
/// @throws BadInput for evidence with values that are not finite or sigmas that are not positive,
///         and for a prior whose weights or covariances are none
Posterior localize(const ObjectModel& model, const Evidence& evidence, RandomStream random,
                   const LocalizerOptions& options = {});

}  // namespace palpate::localization
