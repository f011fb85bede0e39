// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/registration/pose.hpp"
#include "palpate/registration/registration.hpp"
#include "palpate/registration/robust_bound.hpp"
#include "processor_time.hpp"
#include "registration/dual_sdp.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::processor_seconds;
using experiment::Table;

Matrix10d objective_of(std::size_t pairs, Primitive primitive, double outliers,
                       RandomStream random) {
  const auto problem = testing::make_problem(
      {.pairs = pairs, .outliers = outliers, .noise = 0.001, .normal_deg = 5}, random);
  const auto& c = problem.correspondences;
  return marginalize(quadratic_form(c, {}, primitive, weighted_means(c, {}))).objective;
}

double cost_of(const Matrix10d& objective, const Eigen::Matrix3d& R) {
  const Vector10d r = homogeneous(R);
  return r.dot(objective * r);
}

/// Certified share and time, by number of correspondences.
void certified(const experiment::Options& options) {
  Table table({"correspondences", "primitive", "runs", "certified", "median us", "p99 us"});
  for (const Primitive primitive : {Primitive::kPlane, Primitive::kPoint}) {
    for (const std::size_t pairs : {4, 7, 10, 20, 50, 200, 1000}) {
      if (primitive == Primitive::kPlane && pairs < 7) continue;  // degenerate
      const std::uint64_t runs = options.quick ? 20 : 1000;
      std::vector<double> microseconds;
      int count = 0;
      for (std::uint64_t k = 0; k < runs; ++k) {
        const Matrix10d objective =
            objective_of(pairs, primitive, 0, RandomStream(options.seed + k, "certify"));
        double shortest = 1;
        RotationEstimate estimate;
        for (int repeat = 0; repeat < 3; ++repeat) {
          const double start = processor_seconds();
          estimate = solve_rotation(objective);
          shortest = std::min(shortest, processor_seconds() - start);
        }
        count += estimate.certificate.certified;
        microseconds.push_back(1e6 * shortest);
      }
      table.add_row({fmt::format("{}", pairs), primitive == Primitive::kPlane ? "plane" : "point",
                     fmt::format("{}", runs), fmt::format("{}", count),
                     fmt::format("{:.1f}", quantile(microseconds, 0.5)),
                     fmt::format("{:.1f}", quantile(microseconds, 0.99))});
    }
  }
  table.publish(options, "certified", "Problems without outliers: solved and certified");
}

struct Counts {
  int local_minima = 0, perturbed = 0, falsely_certified = 0;
};

/// Local minima from random starts that cost clearly more than the best, and rotations moved off
/// the minimum: none may be certified. A certificate allows 1e-6 of the reference, so that only
/// rotations that cost more than that are wrong.
void tempt(const Matrix10d& objective, int starts, RandomStream& random, Counts& counts) {
  const RotationEstimate best = solve_rotation(objective);
  const double least = best.certificate.cost;
  const double allowed = 2e-6 * std::max(least, objective.trace() / 10);
  for (int k = 0; k < starts; ++k) {
    const Eigen::Matrix3d R = refine_rotation(objective, random.rotation());
    if (cost_of(objective, R) > least + allowed) {
      ++counts.local_minima;
      counts.falsely_certified += certify_rotation(objective, R).certified;
    }
    const double angle = std::pow(10, random.uniform(-2.5, 0));
    const Eigen::Matrix3d off = best.R * exp_so3(angle * random.unit_vector());
    if (cost_of(objective, off) > least + allowed) {
      ++counts.perturbed;
      counts.falsely_certified += certify_rotation(objective, off).certified;
    }
  }
}

void false_certificates(const experiment::Options& options) {
  Counts counts;
  RandomStream random(options.seed, "tempt");
  const std::uint64_t problems = options.quick ? 10 : 3000;
  for (std::uint64_t k = 0; k < problems; ++k) {
    const std::size_t pairs = k % 3 == 0 ? 7 : k % 3 == 1 ? 12 : 40;
    const auto primitive = k % 4 == 0 ? Primitive::kPoint : Primitive::kPlane;
    tempt(objective_of(pairs, primitive, k % 2 == 0 ? 0 : 0.5,
                       RandomStream(options.seed + k, "tempt")),
          40, random, counts);
  }
  Table table({"wrong local minima", "perturbed rotations", "falsely certified"});
  table.add_row({fmt::format("{}", counts.local_minima), fmt::format("{}", counts.perturbed),
                 fmt::format("{}", counts.falsely_certified)});
  table.publish(options, "false_certificates", "Rotations that must not be certified");
}

/// The dual's optimum beside the fast solution's cost, in max(f*, tr(Q~)/10).
void against_dual(const experiment::Options& options) {
  Table table(
      {"correspondences", "primitive", "problems", "median difference", "largest", "above 1e-6"});
  const std::uint64_t runs = options.quick ? 2 : 60;
  for (const Primitive primitive : {Primitive::kPlane, Primitive::kPoint}) {
    for (const std::size_t pairs : {7, 10, 50, 1000}) {
      std::vector<double> differences;
      for (std::uint64_t k = 0; k < runs; ++k) {
        const Matrix10d objective = objective_of(pairs, primitive, k % 2 == 0 ? 0 : 0.5,
                                                 RandomStream(options.seed + k, "dual"));
        const double cost = solve_rotation(objective).certificate.cost;
        differences.push_back(std::abs(cost - solve_dual(objective).value) /
                              std::max(cost, objective.trace() / 10));
      }
      const auto above = std::ranges::count_if(differences, [](double d) { return d > 1e-6; });
      table.add_row({fmt::format("{}", pairs), primitive == Primitive::kPlane ? "plane" : "point",
                     fmt::format("{}", runs), fmt::format("{:.1e}", median(differences)),
                     fmt::format("{:.1e}", quantile(differences, 1)), fmt::format("{}", above)});
    }
  }
  table.publish(options, "dual", "Fast solution against the dual semidefinite program");
}

/// Mean inliers found, and the most that any pose can have.
std::vector<std::string> bounded(std::size_t pairs, double outliers, bool box, std::uint64_t first,
                                 std::uint64_t runs) {
  constexpr double kNoiseBound = 0.004;
  double found = 0, most = 0, seconds = 0;
  for (std::uint64_t seed = first; seed < first + runs; ++seed) {
    const auto problem = testing::make_problem(
        {.pairs = pairs, .outliers = outliers, .noise = 0.001, .box_outliers = box},
        RandomStream(seed, "robust bound"));
    const auto& c = problem.correspondences;
    const auto inliers =
        static_cast<int>(register_correspondences(c, {.best_effort = true}).inliers.size());
    const RobustBound bound =
        bound_inliers(c, kNoiseBound, inliers, {.max_nodes = 100000, .max_seconds = 1});
    found += inliers;
    most += bound.max_inliers;
    seconds += bound.seconds;
  }
  const auto n = static_cast<double>(runs);
  return {fmt::format("{}, {:g} %", pairs, 100 * outliers),
          box ? "box" : "surface",
          fmt::format("{}", runs),
          fmt::format("{:.1f}", found / n),
          fmt::format("{:.1f}", most / n),
          fmt::format("{:.3f}", seconds / n)};
}

/// No pose has more inliers: how far that is above those of the answer.
void robust_bounds(const experiment::Options& options) {
  Table table({"pairs, wrong", "wrong ones", "runs", "inliers found", "at most", "s"});
  for (const std::size_t pairs : {100, 300, 1000}) {
    if (options.quick && pairs > 100) break;
    const double largest = pairs == 100 ? 0.95 : 0.98;
    for (const double outliers : {0.5, 0.9, largest}) {
      for (const bool box : {false, true}) {
        table.add_row(bounded(pairs, outliers, box, options.seed, options.quick ? 1 : 5));
      }
    }
  }
  table.publish(options, "robust_bounds", "The most inliers that any pose can have");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_certificate",
                         "What the certificate of rotations achieves: certified problems and time, "
                         "false certificates, agreement with the dual program, bounds on "
                         "the inliers of any pose.",
                         [](const experiment::Options& options) {
                           certified(options);
                           false_certificates(options);
                           against_dual(options);
                           robust_bounds(options);
                         });
}
