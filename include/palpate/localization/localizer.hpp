// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "palpate/core/random.hpp"
#include "palpate/geometry/distance_field.hpp"
#include "palpate/geometry/known_object.hpp"
#include "palpate/localization/evidence.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

class Clearance;

/// An object prepared for the search: distance field and surface samples. Shared by threads.
class ObjectModel {
 public:
  explicit ObjectModel(geometry::KnownObject object);
  ~ObjectModel();
  ObjectModel(ObjectModel&&) noexcept;
  const geometry::KnownObject& object() const { return object_; }
  const geometry::DistanceField& field() const { return field_; }
  struct SurfacePoint {
    Eigen::Vector3f p, n;
  };
  const std::vector<SurfacePoint>& surface() const { return surface_; }
  double area() const { return area_; }
  const Clearance& clearance() const { return *clearance_; }
  const Eigen::AlignedBox3f& bounds() const { return bounds_; }

 private:
  geometry::KnownObject object_;
  double area_;
  Eigen::AlignedBox3f bounds_;
  geometry::DistanceField field_;
  std::vector<SurfacePoint> surface_;
  std::unique_ptr<const Clearance> clearance_;
};

struct LocalizerOptions {
  int proposals = 40000;     ///< poses screened
  int particles = 800;       ///< carried through the tempering
  int moves = 6;             ///< Metropolis moves a particle and level
  int starts = 200;          ///< best proposals that are refined before the sampling
  int modes = 16;            ///< reported at most
  double first_scale = 3.0;  ///< noise scale at which the search starts
  double contact_offset =
      0.003;  ///< distance outside the surface at which contacts are compared, m

  template <class Visitor>
  void visit(Visitor&& v) {
    v("proposals", proposals, 1000, 10000000, "poses screened");
    v("particles", particles, 50, 1000000, "poses carried through the tempering");
    v("moves", moves, 1, 1000, "Metropolis moves a particle and level");
    v("starts", starts, 0, 100000, "best proposals that are refined before the sampling");
    v("modes", modes, 1, 1000, "modes reported at most");
    v("first_scale", first_scale, 1.0, 20.0, "noise scale at which the search starts");
    v("contact_offset", contact_offset, 0.0, 0.02, "m outside the surface where contacts compare");
  }
};

struct FastOptions {
  int proposals = 6000;     ///< poses screened
  int starts = 40;          ///< of these refined
  double certainty = 0.99;  ///< weight of the best mode below which the full search decides

  template <class Visitor>
  void visit(Visitor&& v) {
    v("proposals", proposals, 100, 10000000, "poses screened");
    v("starts", starts, 4, 100000, "best of these, which are refined");
    v("certainty", certainty, 0.5, 1.0, "weight of the best below which the full search decides");
  }
};

/// Posterior of the object's pose in the evidence's frame, by tempered sequential Monte Carlo.
///
/// Without a table or a prior at least one contact is needed, else the status is no_pose. Of more
/// than 64 contacts so many are used. no_pose is also the answer where even the best pose leaves
/// the contacts unexplained.
/// @throws BadInput for evidence with values that are not finite, sigmas that are not positive,
///         contacts spread as if in millimetres, and a prior whose weights or covariances are none
Posterior localize(const ObjectModel& model, const Evidence& evidence, RandomStream random,
                   const LocalizerOptions& options = {});

/// As localize, in a tenth of the time where the evidence settles the pose: the best proposals are
/// refined by Levenberg-Marquardt and weighed by Laplace's approximation. Where several poses
/// survive, one was found from too few starts to trust that none is missing, or a direction stays
/// open, localize decides.
Posterior localize_fast(const ObjectModel& model, const Evidence& evidence, RandomStream random,
                        const LocalizerOptions& options = {}, const FastOptions& fast = {});

}  // namespace palpate::localization
