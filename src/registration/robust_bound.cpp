// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/robust_bound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/core/error.hpp"
#include "registration/clique_bound.hpp"
#include "registration/clock.hpp"

namespace palpate::registration {
namespace {

/// Pairs that can be inliers of one pose: lengths differ by at most twice the bound.
CliqueGraph compatible(const Correspondences& c, double noise_bound) {
  const int size = static_cast<int>(c.size());
  CliqueGraph graph(size);
  // What rounding may add to a length, so that it never cuts an edge.
  constexpr double kRounding = 1e-12;
  for (int i = 0; i < size; ++i) {
    const auto a = static_cast<std::size_t>(i);
    for (int j = i + 1; j < size; ++j) {
      const auto b = static_cast<std::size_t>(j);
      const double s = (c.source[a] - c.source[b]).norm(), t = (c.target[a] - c.target[b]).norm();
      if (std::abs(s - t) <= 2 * noise_bound + kRounding * (s + t)) graph.join(i, j);
    }
  }
  return graph;
}

}  // namespace

RobustBound bound_inliers(const Correspondences& correspondences, double noise_bound, int inliers,
                          const RobustBoundOptions& options) {
  check(correspondences);
  if (!(noise_bound > 0) || !std::isfinite(noise_bound)) {
    throw BadInput(fmt::format("noise bound {} m is not positive", noise_bound));
  }
  const double start = now();
  const int size = static_cast<int>(correspondences.size());
  RobustBound bound;
  bound.max_inliers = size;
  if (size <= options.max_pairs) {
    const CliqueGraph graph = compatible(correspondences, noise_bound);
    CliqueBound cliques(graph, inliers, options.max_nodes, start + options.max_seconds);
    bound.max_inliers = cliques.run();
    bound.is_exhausted = cliques.is_exhausted();
    bound.nodes = cliques.nodes();
  }
  bound.min_cost = (size - bound.max_inliers) * noise_bound * noise_bound;
  bound.seconds = now() - start;
  return bound;
}

}  // namespace palpate::registration
