// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/registration/registration.hpp"
#include "processor_time.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;
using testing::make_problem;

bool is_right(const std::optional<Eigen::Isometry3d>& T, const Eigen::Isometry3d& truth) {
  return T && testing::rotation_error_deg(*T, truth) < 5 &&
         testing::translation_error_mm(*T, truth) < 10;
}

std::uint64_t runs(const experiment::Options& options, std::uint64_t all) {
  return options.quick ? 2 : all;
}

/// Some of the wrong pairs agree on a second, smaller consensus.
void two_poses(const experiment::Options& options) {
  Table table({"first, second", "runs", "largest", "runner-up right", "median ms"});
  for (const auto& [first, second] :
       {std::pair{0.7, 0.1}, {0.5, 0.25}, {0.2, 0.1}, {0.1, 0.05}, {0.05, 0.03}}) {
    std::size_t right = 0, runner_up = 0;
    std::vector<double> milliseconds;
    const std::uint64_t count = runs(options, 80);
    for (std::uint64_t k = 0; k < count; ++k) {
      auto problem = make_problem({.outliers = 1 - first, .noise = 0.001},
                                  RandomStream(options.seed + k, "two poses"));
      RandomStream random(options.seed + k, "second pose");
      const Eigen::Isometry3d other = testing::random_pose(random);
      auto& c = problem.correspondences;
      auto left = static_cast<int>(std::lround(second * static_cast<double>(c.size())));
      for (std::size_t i = 0; i < c.size() && left > 0; ++i) {
        if (problem.inlier[i]) continue;
        c.target[i] = other * c.source[i] + 0.001 * random.normal3();
        --left;
      }
      const double start = experiment::processor_seconds();
      const auto result = register_correspondences(c);
      milliseconds.push_back(1e3 * (experiment::processor_seconds() - start));
      right += is_right(result.T_target_source, problem.truth);
      runner_up += result.runner_up && is_right(result.runner_up->T_target_source, other);
    }
    table.add_row({fmt::format("{}, {}", first, second), fmt::format("{}", count),
                   fmt::format("{}", right), fmt::format("{}", runner_up),
                   fmt::format("{:.3g}", quantile(milliseconds, 0.5))});
  }
  table.publish(options, "two_poses", "A second pose in some of the wrong pairs");
}

/// Wrong pairs alone, each several times with a little jitter.
void copies(const experiment::Options& options) {
  Table table({"pairs", "copies", "jitter m", "runs", "poses"});
  for (const int pairs : {40, 200}) {
    for (const int times : {2, 5, 100}) {
      for (const double jitter : {0.0, 1e-9, 5e-4, 2e-3}) {
        const std::uint64_t count = runs(options, 60);
        int poses = 0;
        for (std::uint64_t k = 0; k < count; ++k) {
          const auto base = make_problem({.pairs = static_cast<std::size_t>(pairs),
                                          .outliers = 1,
                                          .noise = 0.001,
                                          .box_outliers = true},
                                         RandomStream(options.seed + k, "copied pairs"));
          RandomStream random(options.seed + k, "jitter");
          Correspondences c;
          for (int copy = 0; copy < times; ++copy) {
            for (std::size_t i = 0; i < base.correspondences.size(); ++i) {
              c.source.push_back(base.correspondences.source[i] + jitter * random.normal3());
              c.target.push_back(base.correspondences.target[i] + jitter * random.normal3());
            }
          }
          poses += register_correspondences(c).T_target_source.has_value();
        }
        table.add_row({fmt::format("{}", pairs), fmt::format("{}", times),
                       fmt::format("{}", jitter), fmt::format("{}", count),
                       fmt::format("{}", poses)});
      }
    }
  }
  table.publish(options, "copies", "Wrong pairs alone, copied with jitter (m an axis)");
}

/// Normalised estimation error squared: 6 if the covariance is right.
void consistency(const experiment::Options& options) {
  Table table({"outliers", "runs", "mean NEES"});
  for (const double share : {0.1, 0.5, 0.9, 0.95, 0.98, 0.99}) {
    double sum = 0;
    int found = 0;
    for (std::uint64_t k = 0; k < runs(options, 100); ++k) {
      const auto problem = make_problem({.outliers = share, .noise = 0.001},
                                        RandomStream(options.seed + k, "consistency"));
      const auto result = register_correspondences(problem.correspondences);
      if (!is_right(result.T_target_source, problem.truth)) continue;
      const Vector6d error = log_se3(problem.truth * result.T_target_source->inverse());
      sum += error.dot(result.covariance.ldlt().solve(error));
      ++found;
    }
    table.add_row({fmt::format("{:.0f} %", 100 * share), fmt::format("{}", found),
                   fmt::format("{:.2f}", sum / std::max(1, found))});
  }
  table.publish(options, "nees", "Error of right poses in units of their covariance");
}

void hostile(const experiment::Options& options) {
  Table table({"problem", "runs", "right"});
  const auto add = [&](const std::string& name, std::uint64_t count, const auto& solve) {
    int right = 0;
    for (std::uint64_t k = 0; k < count; ++k) right += solve(options.seed + k);
    table.add_row({name, fmt::format("{}", count), fmt::format("{}", right)});
  };
  add("6 pairs, 50 %, best effort", runs(options, 60), [](std::uint64_t seed) {
    const auto p =
        make_problem({.pairs = 6, .outliers = 0.5, .noise = 0.001}, RandomStream(seed, "six"));
    return is_right(
        register_correspondences(p.correspondences, {.best_effort = true}).T_target_source,
        p.truth);
  });
  add("a coordinate of 1e10 m", runs(options, 20), [](std::uint64_t seed) {
    auto p =
        make_problem({.pairs = 200, .outliers = 0.5, .noise = 0.001}, RandomStream(seed, "huge"));
    p.correspondences.source[3][0] = 1e10;
    return is_right(register_correspondences(p.correspondences).T_target_source, p.truth);
  });
  add("100000 pairs, every 25th right", runs(options, 10), [](std::uint64_t seed) {
    auto p = make_problem({.pairs = 100000, .outliers = 1, .box_outliers = true},
                          RandomStream(seed, "periodic"));
    RandomStream random(seed, "noise");
    auto& c = p.correspondences;
    for (std::size_t i = 1; i < c.size(); i += 25) {
      c.target[i] = p.truth * c.source[i] + 0.001 * random.normal3();
    }
    return is_right(register_correspondences(c).T_target_source, p.truth);
  });
  table.publish(options, "hostile", "Small and hostile input");
}

/// Of 300 pairs, some agree with a pose and others with a reflection of the source.
void reflections(const experiment::Options& options) {
  Table table({"right", "mirrored", "runs", "flagged", "right poses", "wrong poses", "median ms"});
  for (const auto& [right, mirrored] :
       {std::pair{20, 200}, {60, 200}, {20, 60}, {60, 60}, {200, 20}, {0, 200}, {0, 30}}) {
    int flagged = 0, right_poses = 0, wrong_poses = 0;
    std::vector<double> milliseconds;
    const std::uint64_t count = runs(options, 50);
    for (std::uint64_t k = 0; k < count; ++k) {
      auto p = make_problem({.pairs = 300, .outliers = 1, .noise = 0.001, .box_outliers = true},
                            RandomStream(options.seed + k, "reflection"));
      RandomStream random(options.seed + k, "other pose");
      const Eigen::Isometry3d other = testing::random_pose(random);
      auto& c = p.correspondences;
      for (int i = 0; i < right + mirrored; ++i) {
        Eigen::Vector3d at = c.source[static_cast<std::size_t>(i)];
        if (i >= right) at.x() = -at.x();
        c.target[static_cast<std::size_t>(i)] =
            (i < right ? p.truth : other) * at + 0.001 * random.normal3();
      }
      const double start = experiment::processor_seconds();
      const auto result = register_correspondences(c);
      milliseconds.push_back(1e3 * (experiment::processor_seconds() - start));
      flagged += result.mirrored;
      if (!result.T_target_source) continue;
      ++(is_right(result.T_target_source, p.truth) ? right_poses : wrong_poses);
    }
    table.add_row({fmt::format("{}", right), fmt::format("{}", mirrored), fmt::format("{}", count),
                   fmt::format("{}", flagged), fmt::format("{}", right_poses),
                   fmt::format("{}", wrong_poses),
                   fmt::format("{:.3g}", quantile(milliseconds, 0.5))});
  }
  table.publish(options, "reflections", "Pairs that agree with a reflection among 300");
}

void experiment_consensus(const experiment::Options& options) {
  two_poses(options);
  copies(options);
  consistency(options);
  hostile(options);
  reflections(options);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_consensus",
                         "The largest of two consensuses, copied wrong pairs, consistency of the "
                         "covariance, and hostile input.",
                         experiment_consensus);
}
