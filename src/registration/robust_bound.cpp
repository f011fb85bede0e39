// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/robust_bound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/error.hpp"
#include "registration/clique_bound.hpp"
#include "registration/clock.hpp"
#include "registration/rotation_bound.hpp"

namespace palpate::registration {
namespace {

/// Pairs that can be inliers of one pose: lengths differ by at most twice the bound.
/// @return nothing if the deadline, as now(), passes before
std::optional<CliqueGraph> compatible(const Correspondences& c, double noise_bound,
                                      double deadline) {
  const int size = static_cast<int>(c.size());
  CliqueGraph graph(size);
  // What rounding may add to a length, so that it never cuts an edge.
  constexpr double kRounding = 1e-12;
  for (int i = 0; i < size; ++i) {
    if (now() > deadline) return std::nullopt;
    const auto a = static_cast<std::size_t>(i);
    for (int j = i + 1; j < size; ++j) {
      const auto b = static_cast<std::size_t>(j);
      const double s = (c.source[a] - c.source[b]).norm(), t = (c.target[a] - c.target[b]).norm();
      if (std::abs(s - t) <= 2 * noise_bound + kRounding * (s + t)) graph.join(i, j);
    }
  }
  return graph;
}

std::vector<int> neighbours_among(const CliqueGraph& graph, int vertex,
                                  const std::vector<char>& left) {
  std::vector<int> result;
  for_each_bit(graph.row(vertex), graph.words(), [&](int i) {
    if (left[static_cast<std::size_t>(i)] != 0) result.push_back(i);
  });
  return result;
}

/// The pairs that may be inliers of a pose with more than `inliers`: none of the others is, so that
/// these prove one another out in turn.
std::vector<int> possible_inliers(const Correspondences& c, double noise_bound,
                                  const CliqueGraph& graph, int inliers, Budget& budget) {
  const RotationBound rotations(c, noise_bound);
  std::vector<char> left(c.size(), 1);
  std::vector<std::optional<Eigen::Vector3d>> witnesses(c.size());
  for (bool changed = true; changed && !budget.is_spent;) {
    changed = false;
    for (int i = 0; i < graph.size(); ++i) {
      const auto index = static_cast<std::size_t>(i);
      if (left[index] == 0) continue;
      if (budget.is_late()) break;
      const auto others = neighbours_among(graph, i, left);
      if (rotations.can_have(i, others, inliers, witnesses[index], budget)) continue;
      left[index] = 0;
      changed = true;
    }
  }
  std::vector<int> result;
  for (int i = 0; i < graph.size(); ++i) {
    if (left[static_cast<std::size_t>(i)] != 0) result.push_back(i);
  }
  return result;
}

void bound_by_cliques(const CliqueGraph& graph, int inliers, const RobustBoundOptions& options,
                      double start, RobustBound& bound) {
  CliqueBound cliques(graph, inliers, options.max_nodes - bound.nodes, start + options.max_seconds);
  bound.max_inliers = std::min(bound.max_inliers, std::max(inliers, cliques.run()));
  bound.is_exhausted = bound.is_exhausted || cliques.is_exhausted();
  bound.nodes += cliques.nodes();
}

/// Cliques of what the rotations leave, by half of the work that is left for them.
void bound_by_rotations(const Correspondences& c, double noise_bound, const CliqueGraph& graph,
                        int inliers, const RobustBoundOptions& options, double start,
                        RobustBound& bound) {
  const double end = start + options.max_seconds;
  Budget budget{.nodes = (options.max_nodes - bound.nodes) / 2, .deadline = (now() + end) / 2};
  const auto possible = possible_inliers(c, noise_bound, graph, inliers, budget);
  bound.nodes += budget.used;
  if (possible.size() == c.size()) return;
  const auto rest = compatible(subset(c, possible), noise_bound, end);
  if (rest) bound_by_cliques(*rest, inliers, options, start, bound);
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
    const auto graph = compatible(correspondences, noise_bound, start + options.max_seconds);
    if (graph) bound_by_cliques(*graph, inliers, options, start, bound);
    if (graph && bound.max_inliers > inliers) {
      bound_by_rotations(correspondences, noise_bound, *graph, inliers, options, start, bound);
    }
  }
  bound.min_cost = (size - bound.max_inliers) * noise_bound * noise_bound;
  bound.seconds = now() - start;
  return bound;
}

}  // namespace palpate::registration
