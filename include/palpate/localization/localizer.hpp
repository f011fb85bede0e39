// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/evidence.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

struct LocalizerOptions {
  int proposals = 40000;     ///< poses screened
  int particles = 800;       ///< carried through the tempering
  int moves = 6;             ///< Metropolis moves a particle and level
  int starts = 200;          ///< best proposals that are refined before the sampling
  int modes = 16;            ///< reported at most
  double first_scale = 3.0;  ///< noise scale at which the search starts
  /// Least error of a contact point at which it starts, m: the basins of more exact contacts are so
  /// narrow that it would miss some.
  double first_point_sigma = 0.003;
  double contact_offset =
      0.003;  ///< distance outside the surface at which contacts are compared, m

  template <class Visitor>
  void visit(Visitor&& v) {
    v("proposals", proposals, 1000, 10000000, "number of poses that are proposed and screened");
    v("particles", particles, 50, 1000000, "number of particles of the annealed search");
    v.expert("moves", moves, 1, 1000, "Metropolis moves per particle and noise level");
    v.expert("starts", starts, 0, 100000, "number of best proposals that are refined");
    v("modes", modes, 1, 1000, "number of modes reported at most");
    v.expert("first_scale", first_scale, 1.0, 20.0, "noise scale at which the search starts");
    v.expert("first_point_sigma", first_point_sigma, 0.0, 0.1,
             "m, least error of a contact point at which the search starts");
    v.expert("contact_offset", contact_offset, 0.0, 0.02,
             "m, distance outside the surface at which contacts are compared");
  }
};

struct FastOptions {
  int proposals = 6000;     ///< poses screened
  int starts = 40;          ///< of these refined
  double certainty = 0.99;  ///< weight of the best mode below which the full search decides

  template <class Visitor>
  void visit(Visitor&& v) {
    v("proposals", proposals, 100, 10000000, "number of poses that are proposed and screened");
    v.expert("starts", starts, 4, 100000, "number of best proposals that are refined");
    v("certainty", certainty, 0.5, 1.0,
      "weight of the best mode below which the full search is run");
  }
};

/// Posterior of the object's pose in the evidence's frame, by tempered sequential Monte Carlo.
///
/// Without a table or a prior at least one contact is needed, else the status is no_pose; so it is
/// where even the best pose does not explain the contacts. At most 64 contacts are used. Contacts
/// of one finger at distances below two standard deviations (point_sigma; at most 3 mm) count as
/// one measurement.
/// @throws BadInput for evidence with values that are not finite, sigmas that are not positive,
///         contacts spread as if in millimetres, and a prior whose weights or covariances are none
Posterior localize(const geometry::ObjectModel& model, const Evidence& evidence,
                   RandomStream random, const LocalizerOptions& options = {});

/// As localize, in a tenth of the time where the evidence settles the pose: the best proposals are
/// refined by Levenberg-Marquardt and weighed by samples about them. Where several poses survive,
/// one was found from too few starts to trust that none is missing, or a direction stays open,
/// localize decides.
Posterior localize_fast(const geometry::ObjectModel& model, const Evidence& evidence,
                        RandomStream random, const LocalizerOptions& options = {},
                        const FastOptions& fast = {});

}  // namespace palpate::localization
