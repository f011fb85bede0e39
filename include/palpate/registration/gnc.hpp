// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

enum class RobustCost {
  kTruncatedLeastSquares,  ///< rho(r) = min(r^2, c^2)
  kGemanMcClure,           ///< rho(r) = c^2 r^2 / (c^2 + r^2)
};

/// Graduated surrogate rho_mu of the squared residual, m^2 (Yang et al., RA-L 2020, eqs 4 and 6;
/// thesis fig. 6.2). TLS becomes exact as mu -> inf, Geman-McClure at mu = 1.
/// @param bound  c, m
double surrogate_cost(RobustCost cost, double squared_residual, double mu, double bound);

/// Weight that minimises w r^2 + Phi(w) (TLS: thesis eq. 6.15; Geman-McClure: Yang et al. eq. 12).
double surrogate_weight(RobustCost cost, double squared_residual, double mu, double bound);

/// mu at which the surrogate starts nearly convex: TLS c^2 / (2 r_max^2 - c^2), or nothing where
/// 2 r_max^2 <= c^2 (every residual is an inlier's already); Geman-McClure 2 r_max^2 / c^2. The
/// thesis prints the latter for TLS, which starts with the hard cost.
std::optional<double> initial_mu(RobustCost cost, double largest_squared_residual, double bound);

struct GncOptions {
  RobustCost cost = RobustCost::kTruncatedLeastSquares;
  Primitive primitive = Primitive::kPoint;
  double noise_bound = 0.004;  ///< c, m: the largest residual of an inlier
  double factor = 1.4;         ///< mu grows (TLS) or shrinks (Geman-McClure) by this, > 1
  std::optional<double> start_mu = std::nullopt;  ///< instead of initial_mu()
  int max_iterations = 200;
  /// Stops once the weighted cost changes by less than this share of c^2 a pair, thesis eq. 6.17.
  double cost_tolerance = 1e-9;
  bool keep_history = false;
};

/// Why GNC stopped.
enum class GncStop {
  kAllInliers,     ///< the start is convex no more: nothing to reject
  kWeightsBinary,  ///< every weight is 0 or 1 to 1e-6 (TLS)
  kCostConverged,
  kSurrogateExact,  ///< mu has reached 1 (Geman-McClure)
  kNothingLeft,     ///< weights sum to less than three pairs with mu past 1 (TLS)
  kMaxIterations,
};

std::string_view to_string(GncStop stop);

struct GncIteration {
  double mu = 0;
  double cost = 0;              ///< sum of w r^2 times the pairs' own weights, m^2
  std::vector<double> weights;  ///< after the update
};

struct GncResult {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  std::vector<double> weights;  ///< one a pair, 0..1, without its own; 0 for pairs of weight 0
  int iterations = 0;
  GncStop stop = GncStop::kMaxIterations;
  std::vector<GncIteration> history;  ///< if asked for
};

/// Graduated non-convexity: weighted poses with weights from a surrogate that grows from nearly
/// convex to the robust cost (thesis Algorithm 1 with the start of Yang et al.). The pairs' own
/// weights, if there are any, multiply their costs.
/// @throws BadInput as check(), and for a bound, factor or start_mu that is not positive (factor:
///         above 1)
GncResult graduated_non_convexity(const Correspondences& correspondences,
                                  const GncOptions& options = {});

}  // namespace palpate::registration
