// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/registration/registration.hpp"
#include "processor_time.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::processor_seconds;
using experiment::Table;

/// What a row of a table stands for.
struct Setting {
  std::string name;
  testing::ProblemOptions problem;
  RegistrationOptions options;
  std::size_t runs = 200;
  int repeats = 3;     ///< of which the shortest time counts
  double min_off = 0;  ///< m; pairs that are right to within this are left out
};

struct Outcomes {
  std::vector<double> degrees, millimetres, milliseconds;
  std::size_t successes = 0, no_consensus = 0, wrong = 0;
};

/// Shortest of several times, in `seconds`; the results do not differ.
RegistrationResult timed(const Correspondences& correspondences, const RegistrationOptions& options,
                         int repeats) {
  RegistrationResult result;
  double shortest = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const double start = processor_seconds();
    result = register_correspondences(correspondences, options);
    shortest = std::min(shortest, processor_seconds() - start);
  }
  result.seconds = shortest;
  return result;
}

/// Leaves out pairs that are right to within a distance, by accident or not.
void leave_out(testing::Problem& problem, double distance) {
  auto& c = problem.correspondences;
  std::vector<int> kept;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const double off = (problem.truth * c.source[i] - c.target[i]).norm();
    if (off >= distance) kept.push_back(static_cast<int>(i));
  }
  c = subset(c, kept);
}

Outcomes run(const Setting& setting, std::uint64_t first_seed) {
  Outcomes outcomes;
  for (std::uint64_t k = 0; k < setting.runs; ++k) {
    auto problem =
        testing::make_problem(setting.problem, RandomStream(first_seed + k, "registration_table"));
    if (setting.min_off > 0) leave_out(problem, setting.min_off);
    const RegistrationResult result =
        timed(problem.correspondences, setting.options, setting.repeats);
    outcomes.milliseconds.push_back(1e3 * result.seconds);
    if (!result.T_target_source) {
      ++outcomes.no_consensus;
      continue;
    }
    const double degrees = testing::rotation_error_deg(*result.T_target_source, problem.truth);
    const double millimetres =
        testing::translation_error_mm(*result.T_target_source, problem.truth);
    const bool success = degrees < 5 && millimetres < 10;
    outcomes.successes += success;
    outcomes.wrong += !success;
    outcomes.degrees.push_back(degrees);
    outcomes.millimetres.push_back(millimetres);
  }
  return outcomes;
}

std::string number(const std::vector<double>& values, double share) {
  return values.empty() ? "-" : fmt::format("{:.3g}", quantile(values, share));
}

void publish(const experiment::Options& options, const std::string& name, const std::string& title,
             std::vector<Setting> settings) {
  Table table({"setting", "runs", "success", "95 %", "wrong", "no consensus", "median deg",
               "median mm", "median ms", "p99 ms"});
  for (auto& setting : settings) {
    if (options.quick) setting.runs = 2;
    const Outcomes o = run(setting, options.seed);
    const Interval interval = wilson_interval(o.successes, setting.runs);
    table.add_row({setting.name, fmt::format("{}", setting.runs),
                   fmt::format("{:.3f}", static_cast<double>(o.successes) /
                                             static_cast<double>(setting.runs)),
                   fmt::format("{:.3f}..{:.3f}", interval.low, interval.high),
                   fmt::format("{}", o.wrong), fmt::format("{}", o.no_consensus),
                   number(o.degrees, 0.5), number(o.millimetres, 0.5), number(o.milliseconds, 0.5),
                   number(o.milliseconds, 0.99)});
  }
  table.publish(options, name, title);
}

constexpr double kShares[] = {0.1, 0.5, 0.9, 0.95, 0.98, 0.99, 0.995};

std::vector<Setting> outlier_settings(bool normals, bool box,
                                      const geometry::TriangleMesh* mesh = nullptr) {
  std::vector<Setting> settings;
  for (const double share : kShares) {
    settings.push_back({fmt::format("{:.1f} %", 100 * share),
                        {.outliers = share,
                         .noise = 0.001,
                         .normal_deg = 5,
                         .box_outliers = box,
                         .normals = normals,
                         .mesh = mesh},
                        {.normal_noise_deg = normals ? 5.0 : 0.0}});
  }
  return settings;
}

void other_meshes(const experiment::Options& options) {
  for (const std::string name : {"mug", "bracket", "bottle"}) {
    const auto object = geometry::load_known_object(name);
    auto settings = outlier_settings(true, false, &object.mesh);
    for (auto& setting : settings) setting.runs = 50;
    publish(options, "mesh_" + name, "The " + name + ", with normals", settings);
    if (options.quick) break;
  }
}

void sizes(const experiment::Options& options) {
  std::vector<Setting> settings;
  for (const std::size_t pairs : {50, 200, 1000, 10000, 100000}) {
    for (const double share : {0.5, 0.9}) {
      settings.push_back({fmt::format("{} pairs, {:.0f} %", pairs, 100 * share),
                          {.pairs = pairs, .outliers = share, .noise = 0.001},
                          {},
                          50});
    }
    if (options.quick && pairs == 1000) break;
  }
  publish(options, "sizes", "Number of correspondences, without normals", settings);
}

void wrong_bounds(const experiment::Options& options) {
  std::vector<Setting> settings;
  for (const double share : {0.5, 0.9, 0.95, 0.98, 0.99}) {
    for (const double factor : {0.5, 1.0, 2.0}) {
      settings.push_back({fmt::format("{:.0f} %, bound x {}", 100 * share, factor),
                          {.outliers = share, .noise = 0.001, .normal_deg = 5, .normals = true},
                          {.noise_bound = 0.004 * factor, .normal_noise_deg = 5},
                          100});
    }
  }
  publish(options, "bounds", "Noise bound wrong, with normals", settings);
}

std::vector<Setting> outlier_only_settings(const std::string& mesh_name,
                                           const geometry::TriangleMesh* mesh,
                                           const std::vector<std::size_t>& sizes) {
  std::vector<Setting> settings;
  for (const bool box : {false, true}) {
    for (const bool normals : {false, true}) {
      for (const std::size_t pairs : sizes) {
        settings.push_back({fmt::format("{}, {} pairs, {}{}", mesh_name, pairs,
                                        box ? "box" : "shuffled", normals ? ", normals" : ""),
                            {.pairs = pairs,
                             .outliers = 1,
                             .noise = 0.001,
                             .normal_deg = 5,
                             .box_outliers = box,
                             .normals = normals,
                             .mesh = mesh},
                            {.normal_noise_deg = normals ? 5.0 : 0.0},
                            500,
                            1});
      }
    }
  }
  return settings;
}

/// Shuffled pairs hold a few that are right by accident, so that the true pose may be found; those
/// uniform in the box hold none.
void all_outliers(const experiment::Options& options) {
  publish(options, "all_outliers", "Outliers alone: every pose is an accident",
          outlier_only_settings("bunny", nullptr, {20, 100, 1000}));
  for (const std::string name : {"mug", "bracket", "bottle"}) {
    const auto object = geometry::load_known_object(name);
    publish(options, "all_outliers_" + name, "Outliers alone, the " + name,
            outlier_only_settings(name, &object.mesh, {1000}));
    if (options.quick) break;
  }
}

/// Of shuffled pairs some are right to within the bound, the more the wider it is; without those
/// within twice the bound every pose is an accident.
void accidents(const experiment::Options& options) {
  std::vector<Setting> settings;
  for (const bool normals : {true, false}) {
    for (const double factor : {1.0, 2.0}) {
      for (const bool all : {true, false}) {
        const double bound = 0.004 * factor;
        settings.push_back(
            {fmt::format("bound x {}{}{}", factor, normals ? ", normals" : "",
                         all ? "" : ", without pairs right to within twice the bound"),
             {.outliers = 1, .noise = 0.001, .normal_deg = 5, .normals = normals},
             {.noise_bound = bound, .normal_noise_deg = normals ? 5.0 : 0.0},
             500,
             1,
             all ? 0 : 2 * bound});
      }
    }
  }
  publish(options, "accidents", "Bunny, 1000 shuffled pairs alone", settings);
}

/// Long and flat boxes, where poses that lay them on one another agree with much.
void thin_things(const experiment::Options& options) {
  struct Box {
    Eigen::Vector3d size;
    double bound;
  };
  std::vector<geometry::TriangleMesh> meshes;
  std::vector<Setting> settings;
  const std::vector<Box> boxes = {{{0.18, 0.008, 0.008}, 0.004},
                                  {{0.18, 0.008, 0.008}, 0.001},
                                  {{0.3, 0.02, 0.02}, 0.004},
                                  {{0.2, 0.15, 0.002}, 0.004},
                                  {{0.3, 0.03, 0.002}, 0.004}};
  for (const Box& box : boxes) meshes.push_back(geometry::box_mesh(box.size));
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Eigen::Vector3d mm = 1000 * boxes[i].size;
    const double bound = boxes[i].bound;
    for (const bool normals : {false, true}) {
      settings.push_back({fmt::format("{:.0f} x {:.0f} x {:.0f} mm, bound {:.0f} mm{}", mm.x(),
                                      mm.y(), mm.z(), 1000 * bound, normals ? ", normals" : ""),
                          {.outliers = 1,
                           .noise = bound / 4,
                           .normal_deg = 5,
                           .normals = normals,
                           .mesh = &meshes[i]},
                          {.noise_bound = bound, .normal_noise_deg = normals ? 5.0 : 0.0},
                          200,
                          1,
                          2 * bound});
    }
  }
  publish(options, "thin_things", "Long and flat boxes, 1000 wrong pairs alone", settings);
}

void thesis_setting(const experiment::Options& options) {
  std::vector<Setting> settings;
  for (int tens = 1; tens <= 9; ++tens) {
    settings.push_back(
        {fmt::format("{}0 %", tens), {.outliers = 0.1 * tens}, {.noise_bound = 0.001}, 20});
  }
  publish(options, "thesis", "The thesis' own setting: no noise", settings);
}

void experiment_table(const experiment::Options& options) {
  publish(options, "normals", "Bunny, shuffled outliers, with normals",
          outlier_settings(true, false));
  publish(options, "points", "Bunny, shuffled outliers, without normals",
          outlier_settings(false, false));
  publish(options, "box", "Bunny, outliers uniform in the box, without normals",
          outlier_settings(false, true));
  sizes(options);
  other_meshes(options);
  wrong_bounds(options);
  thesis_setting(options);
  all_outliers(options);
  thin_things(options);
  accidents(options);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_table",
                         "Success, error and time of registration against the share of outliers, "
                         "the number of correspondences, the mesh and the noise bound.",
                         experiment_table);
}
