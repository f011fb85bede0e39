// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "consistency_graph.hpp"
#include "experiment.hpp"
#include "palpate/registration/pose.hpp"
#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;

constexpr double kBound = 0.004;  // m

/// N minus the truncated least-squares cost in squared bounds: what the optimum makes largest.
double gain_of(const Correspondences& c, const Eigen::Isometry3d& T, std::vector<double>* inlier) {
  double gain = 0;
  const auto squared = squared_residuals(c, T, Primitive::kPoint);
  for (std::size_t i = 0; i < squared.size(); ++i) {
    const double g = std::max(0.0, 1 - squared[i] / (kBound * kBound));
    if (inlier) (*inlier)[i] = g > 0 ? 1 : 0;
    gain += g;
  }
  return gain;
}

struct Optimum {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  double gain = 0;
  std::size_t triples = 0;
};

/// Inliers and least squares in turn.
void descend(const Correspondences& c, Optimum& best, Eigen::Isometry3d T) {
  std::vector<double> inlier(c.size());
  for (double last = -1, gain = gain_of(c, T, &inlier); gain > last;
       gain = gain_of(c, T, &inlier)) {
    last = gain;
    if (gain > best.gain) {
      best.gain = gain;
      best.T = T;
    }
    T = align_points(c, inlier);
  }
}

/// Every triple that the consistency graph allows proposes a pose; those within reach of the best
/// are refined. Without the search's samples, cliques and order: nothing to miss but what no
/// consistent triple leads to.
Optimum exhaustive(const Correspondences& c) {
  const ConsistencyGraph graph(c, {.noise_bound = kBound});
  Optimum best;
  for (int i = 0; i < graph.size(); ++i) {
    for (int j = i + 1; j < graph.size(); ++j) {
      if (!graph.joined(i, j)) continue;
      for (int k = j + 1; k < graph.size(); ++k) {
        if (!graph.joined(i, k) || !graph.joined(j, k)) continue;
        ++best.triples;
        const Eigen::Isometry3d T = align_points(subset(c, {i, j, k}), {});
        if (gain_of(c, T, nullptr) > 0.6 * best.gain) descend(c, best, T);
      }
    }
  }
  return best;
}

struct Counts {
  int runs = 0, poses = 0, equal = 0, optimum_right = 0, optimum_wrong_refused = 0;
  int optimum_wrong = 0, optimum_right_refused = 0;
};

bool right(const Eigen::Isometry3d& T, const Eigen::Isometry3d& truth) {
  return testing::rotation_error_deg(T, truth) < 5 && testing::translation_error_mm(T, truth) < 10;
}

void count(const testing::Problem& problem, Counts& counts) {
  const Optimum optimum = exhaustive(problem.correspondences);
  const auto result = register_correspondences(problem.correspondences);
  const bool optimum_right = right(optimum.T, problem.truth);
  ++counts.runs;
  counts.optimum_right += optimum_right;
  counts.optimum_wrong += !optimum_right;
  if (result.T_target_source) {
    ++counts.poses;
    const double gain = gain_of(problem.correspondences, *result.T_target_source, nullptr);
    counts.equal += gain > optimum.gain - 0.05;
  } else {
    counts.optimum_wrong_refused += !optimum_right;
    counts.optimum_right_refused += optimum_right;
  }
}

void experiment_exhaustive(const experiment::Options& options) {
  Table table({"outliers", "problems", "exhaustive optimum right", "poses given",
               "equal to the optimum", "refused", "refused, optimum wrong",
               "refused, optimum right"});
  for (const double share : {0.99, 0.995}) {
    Counts n;
    const std::uint64_t runs = options.quick ? 1 : 20;
    for (std::uint64_t k = 0; k < runs; ++k) {
      count(testing::make_problem(
                {.pairs = options.quick ? 300u : 1000u, .outliers = share, .noise = 0.001},
                RandomStream(options.seed + k, "registration_table")),
            n);
    }
    table.add_row({fmt::format("{:.1f} %", 100 * share), fmt::format("{}", n.runs),
                   fmt::format("{}", n.optimum_right), fmt::format("{}", n.poses),
                   fmt::format("{}", n.equal), fmt::format("{}", n.runs - n.poses),
                   fmt::format("{}", n.optimum_wrong_refused),
                   fmt::format("{}", n.optimum_right_refused)});
  }
  table.publish(options, "exhaustive", "Truncated least squares: the search against all triples");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_exhaustive",
                         "Whether the search finds the optimum of truncated least squares that all "
                         "consistent triples together find, without normals.",
                         experiment_exhaustive);
}
