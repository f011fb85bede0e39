// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/registration/gnc.hpp"
#include "palpate/registration/pose.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;

constexpr int kShares = 9;       // 10 % .. 90 %
constexpr double kBound = 1e-3;  // m; the thesis does not print its own

enum class Rule { kLiteral, kCorrected, kUnweighted };

std::string name_of(Rule rule) {
  return rule == Rule::kLiteral ? "literal" : rule == Rule::kCorrected ? "corrected" : "unweighted";
}

/// The thesis' problem (6.3): 1000 points, turned by 45 deg about z, no noise.
testing::Problem thesis_problem(double outliers, std::uint64_t seed, std::size_t pairs) {
  auto problem =
      testing::make_problem({.pairs = pairs, .outliers = outliers}, RandomStream(seed, "thesis"));
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() = Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitZ()).matrix();
  const Eigen::Isometry3d move = turn * problem.truth.inverse();
  for (auto& p : problem.correspondences.target) p = move * p;
  for (auto& n : problem.correspondences.target_normals) n = move.linear() * n;
  problem.truth = turn;
  return problem;
}

struct Run {
  double iterations = 0, seconds = 0, degrees = 0, millimetres = 0, weight_sum = 0;
  bool binary = false;
  GncResult gnc;
};

/// The thesis prints mu = 2 r_max^2 / c^2 as the start for TLS.
double literal_start(const Correspondences& c) {
  const auto first = solve_pose(c, {}, Primitive::kPlane);
  const auto squared = squared_residuals(c, first.T_target_source, Primitive::kPlane);
  return 2 * *std::ranges::max_element(squared) / (kBound * kBound);
}

GncResult reject(const Correspondences& c, Rule rule) {
  if (rule == Rule::kUnweighted) {
    GncResult none;
    none.weights.assign(c.size(), 1);
    return none;
  }
  GncOptions options{.noise_bound = kBound, .keep_history = true};
  if (rule == Rule::kLiteral) {
    options.primitive = Primitive::kPlane;
    options.start_mu = literal_start(c);
  }
  return graduated_non_convexity(c, options);
}

Run run(const testing::Problem& problem, Rule rule) {
  const auto start = std::chrono::steady_clock::now();
  Run result;
  result.gnc = reject(problem.correspondences, rule);
  std::vector<double> inlier;  // the thesis: a last solve of those that are left
  for (const double w : result.gnc.weights) {
    inlier.push_back(w > 0.5 ? 1 : 0);
    result.weight_sum += w;
  }
  const auto pose = solve_pose(problem.correspondences, inlier, Primitive::kPlane);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.iterations = result.gnc.iterations;
  result.degrees = testing::rotation_error_deg(pose.T_target_source, problem.truth);
  result.millimetres = testing::translation_error_mm(pose.T_target_source, problem.truth);
  result.binary =
      std::ranges::all_of(result.gnc.weights, [](double w) { return w < 1e-6 || w > 1 - 1e-6; });
  return result;
}

std::vector<std::string> share_names() {
  std::vector<std::string> names;
  for (int k = 1; k <= kShares; ++k) names.push_back(fmt::format("{}0 %", k));
  return names;
}

using Runs = std::vector<std::vector<Run>>;  // by share of outliers

Runs runs_of(Rule rule, const experiment::Options& options) {
  Runs runs;
  const int repeats = options.quick ? 3 : 20;
  for (int k = 1; k <= kShares; ++k) {
    runs.emplace_back();
    for (int r = 0; r < repeats; ++r) {
      const auto seed = options.seed + static_cast<std::uint64_t>(r);
      runs.back().push_back(run(thesis_problem(0.1 * k, seed, options.quick ? 200 : 1000), rule));
    }
  }
  return runs;
}

std::vector<double> values(const std::vector<Run>& runs, double Run::*member) {
  std::vector<double> result;
  for (const Run& r : runs) result.push_back(r.*member);
  return result;
}

void draw_boxes(const experiment::Options& options, const Runs& literal, const Runs& corrected) {
  struct Figure {
    const char *file, *title, *axis;
    double Run::*member;
    double scale;
    bool logarithmic;
  };
  const Figure figures[] = {
      {"fig_6_5_iterations", "GNC iterations (thesis fig. 6.5)", "outer iterations",
       &Run::iterations, 1, false},
      {"fig_6_6_time", "Time of GNC and last solve (fig. 6.6)", "time (ms)", &Run::seconds, 1e3,
       true},
      {"fig_6_7_angle", "Angle error (fig. 6.7)", "angle error (deg)", &Run::degrees, 1, true},
      {"fig_6_8_position", "Position error (fig. 6.8)", "position error (mm)", &Run::millimetres, 1,
       true}};
  for (const Figure& figure : figures) {
    plotting::Plot plot{.title = figure.title,
                        .x = {.label = "outliers"},
                        .y = {.label = figure.axis, .logarithmic = figure.logarithmic},
                        .categories = share_names()};
    for (const auto& [name, runs] :
         {std::pair{"literal rule", &literal}, {"corrected", &corrected}}) {
      plotting::BoxSeries series{.name = name, .samples = {}};
      for (const auto& share : *runs) {
        auto samples = values(share, figure.member);
        for (double& v : samples) v = std::max(v * figure.scale, figure.logarithmic ? 1e-9 : 0.0);
        series.samples.push_back(samples);
      }
      plot.series.emplace_back(series);
    }
    experiment::publish_figure(options, figure.file, plotting::to_svg(plot));
  }
}

void tabulate(const experiment::Options& options, const std::vector<std::pair<Rule, Runs>>& all) {
  Table table({"outliers", "rule", "median iterations", "median ms", "median deg", "max deg",
               "median mm", "max mm", "runs with weights 0 or 1", "median sum of weights",
               "thesis"});
  for (std::size_t k = 0; k < kShares; ++k) {
    for (const auto& [rule, runs] : all) {
      const auto& share = runs[k];
      const auto binary = std::ranges::count_if(share, [](const Run& r) { return r.binary; });
      const std::string thesis = k == 0   ? "-3 deg, < 0.8 mm, 1010 weights"
                                 : k == 1 ? "-7.66 deg, < 0.8 mm"
                                          : "< 0.8 mm";
      table.add_row({share_names()[k], name_of(rule),
                     fmt::format("{:.0f}", median(values(share, &Run::iterations))),
                     fmt::format("{:.2f}", 1e3 * median(values(share, &Run::seconds))),
                     fmt::format("{:.2g}", median(values(share, &Run::degrees))),
                     fmt::format("{:.2g}", quantile(values(share, &Run::degrees), 1)),
                     fmt::format("{:.2g}", median(values(share, &Run::millimetres))),
                     fmt::format("{:.2g}", quantile(values(share, &Run::millimetres), 1)),
                     fmt::format("{} of {}", binary, share.size()),
                     fmt::format("{:.0f}", median(values(share, &Run::weight_sum))), thesis});
    }
  }
  table.publish(options, "gnc",
                "GNC on the thesis' synthetic problem (1000 points, 45 deg about z, no noise)");
}

plotting::LineSeries nonzero_weights(const std::string& name, const Run& run) {
  plotting::LineSeries line{.name = name, .x = {}, .y = {}};
  for (std::size_t t = 0; t < run.gnc.history.size(); ++t) {
    line.x.push_back(static_cast<double>(t + 1));
    line.y.push_back(static_cast<double>(
        std::ranges::count_if(run.gnc.history[t].weights, [](double w) { return w > 1e-9; })));
  }
  return line;
}

/// Weights of one run (figure 6.9) and, for every share, how many are not zero (6.10, C.1-C.5).
void draw_weights(const experiment::Options& options, const Runs& runs, const std::string& rule) {
  plotting::Plot weights{
      .title = "Weights over the iterations, 10 % outliers, " + rule + " (fig. 6.9)",
      .x = {.label = "outer iteration"},
      .y = {.label = "weight"}};
  const auto& history = runs[0][0].gnc.history;
  for (std::size_t i = 0; i < 60 && !history.empty(); ++i) {
    const std::size_t pair = i * history[0].weights.size() / 60;
    plotting::LineSeries line;
    for (std::size_t t = 0; t < history.size(); ++t) {
      line.x.push_back(static_cast<double>(t + 1));
      line.y.push_back(history[t].weights[pair]);
    }
    weights.series.emplace_back(line);
  }
  experiment::publish_figure(options, "fig_6_9_weights_" + rule, plotting::to_svg(weights));
  for (std::size_t k = 0; k < kShares; ++k) {
    plotting::Plot plot{
        .title = fmt::format("Weights that are not zero, {}0 % outliers, {} ({})", k + 1, rule,
                             k == 0 ? "figs 6.10, C.1" : fmt::format("fig. C.{}", k / 2 + 1)),
        .x = {.label = "outer iteration"},
        .y = {.label = "number of weights"}};
    for (const Run& r : runs[k]) {
      plot.series.emplace_back(nonzero_weights("", r));
    }
    experiment::publish_figure(options, fmt::format("fig_c_nonzero_{}0_{}", k + 1, rule),
                               plotting::to_svg(plot));
  }
}

constexpr double kThesisDegrees[] = {3, 7.66};  // at 10 and 20 %, without their sign (6.5)
constexpr double kThesisMillimetres = 0.8;      // never exceeded at any share (6.5)
constexpr double kThesisWeights = 1010, kThesisIterations = 34;  // at 10 % (6.5, fig. 6.10)

std::vector<double> shares() {
  std::vector<double> shares;
  for (int k = 1; k <= kShares; ++k) shares.push_back(10.0 * k);
  return shares;
}

plotting::LineSeries medians(const std::string& name, const Runs& runs, double Run::*member) {
  plotting::LineSeries line{.name = name, .x = shares(), .y = {}};
  for (const auto& share : runs) line.y.push_back(median(values(share, member)));
  return line;
}

/// The errors of each rule, on an axis on which those of the corrected one are too small to be
/// seen.
plotting::Plot error_plot(const std::string& title, const std::string& unit,
                          const std::vector<std::pair<std::string, const Runs*>>& rules,
                          double Run::*member) {
  constexpr double kLow = 1e-3;
  plotting::Plot plot{
      .title = title,
      .x = {.label = "outliers (%)", .low = 0, .high = 100},
      .y = {.label = fmt::format("median error ({})", unit), .logarithmic = true, .low = kLow}};
  for (const auto& [name, runs] : rules) {
    auto line = medians(name, *runs, member);
    const double largest = *std::ranges::max_element(line.y);
    if (largest < kLow)
      line.name += fmt::format(": at most {:.1e} {}, below the axis", largest, unit);
    plot.series.emplace_back(line);
  }
  return plot;
}

/// Figures 6.7 and 6.8 as far as the thesis prints numbers, beside each rule.
void draw_errors_beside(const experiment::Options& options, const Runs& literal,
                        const Runs& corrected, const Runs& unweighted) {
  const std::vector<std::pair<std::string, const Runs*>> rules = {
      {"rule as printed", &literal}, {"no rejection", &unweighted}, {"corrected rule", &corrected}};
  auto angles = error_plot("Angle error (thesis fig. 6.7)", "deg", rules, &Run::degrees);
  angles.series.emplace_back(
      plotting::ScatterSeries{"thesis", {10, 20}, {kThesisDegrees[0], kThesisDegrees[1]}});
  experiment::publish_figure(options, "beside_6_7_angle", plotting::to_svg(angles));
  auto positions = error_plot("Position error (thesis fig. 6.8)", "mm", rules, &Run::millimetres);
  positions.series.emplace_back(plotting::LineSeries{
      "thesis: never above", shares(), std::vector<double>(kShares, kThesisMillimetres)});
  experiment::publish_figure(options, "beside_6_8_position", plotting::to_svg(positions));
}

/// Figures 6.10 and C.1 to C.5 in one: of the first run of each share.
void draw_weights_beside(const experiment::Options& options, const Runs& corrected) {
  plotting::Plot plot{.title = "Weights that are not zero (thesis figs 6.10, C.1 to C.5)",
                      .x = {.label = "outer iteration", .low = 0},
                      .y = {.label = "number of weights", .low = 0}};
  for (std::size_t k = 0; k < kShares; ++k) {
    plot.series.emplace_back(nonzero_weights(share_names()[k], corrected[k][0]));
  }
  plot.series.emplace_back(
      plotting::ScatterSeries{"thesis, 10 %", {kThesisIterations}, {kThesisWeights}});
  experiment::publish_figure(options, "beside_6_10_weights", plotting::to_svg(plot));
}

void draw_surrogate(const experiment::Options& options) {
  plotting::Plot plot{.title = "TLS surrogate for c = 1 (thesis fig. 6.2)",
                      .x = {.label = "residual r / c"},
                      .y = {.label = "cost / c^2", .high = 2}};
  for (const double mu : {0.05, 0.2, 1.0, 5.0, 100.0}) {
    plotting::LineSeries line{.name = fmt::format("mu = {}", mu), .x = {}, .y = {}};
    for (double r = -3; r <= 3; r += 0.02) {
      line.x.push_back(r);
      line.y.push_back(surrogate_cost(RobustCost::kTruncatedLeastSquares, r * r, mu, 1));
    }
    plot.series.emplace_back(line);
  }
  experiment::publish_figure(options, "fig_6_2_surrogate", plotting::to_svg(plot));
}

/// Source and target of one problem, seen along x.
void draw_clouds(const experiment::Options& options) {
  const auto problem = thesis_problem(0, options.seed, 1000);
  plotting::Plot plot{.title = "Target and source, 45 deg apart, seen from above (fig. 6.3)",
                      .x = {.label = "x (m)"},
                      .y = {.label = "y (m)"},
                      .width = 560,
                      .height = 520};
  for (const auto& [name, points] : {std::pair{"target", &problem.correspondences.target},
                                     {"source", &problem.correspondences.source}}) {
    plotting::ScatterSeries series{.name = name, .x = {}, .y = {}};
    for (const auto& p : *points) {
      series.x.push_back(p.x());
      series.y.push_back(p.y());
    }
    plot.series.emplace_back(series);
  }
  experiment::publish_figure(options, "fig_6_3_clouds", plotting::to_svg(plot));
}

void experiment_gnc(const experiment::Options& options) {
  draw_surrogate(options);
  draw_clouds(options);
  const Runs literal = runs_of(Rule::kLiteral, options),
             corrected = runs_of(Rule::kCorrected, options),
             unweighted = runs_of(Rule::kUnweighted, options);
  tabulate(
      options,
      {{Rule::kLiteral, literal}, {Rule::kCorrected, corrected}, {Rule::kUnweighted, unweighted}});
  draw_boxes(options, literal, corrected);
  draw_weights(options, literal, "literal");
  draw_weights(options, corrected, "corrected");
  draw_errors_beside(options, literal, corrected, unweighted);
  draw_weights_beside(options, corrected);
  fmt::print(
      "\nDoes the literal rule give about 3 deg at 10 % and 7 deg at 20 %? {:.2f} and {:.2f} deg;\n"
      "rejecting nothing gives {:.2f} and {:.2f} deg (largest of 20: {:.2f} and {:.2f}).\n",
      median(values(literal[0], &Run::degrees)), median(values(literal[1], &Run::degrees)),
      median(values(unweighted[0], &Run::degrees)), median(values(unweighted[1], &Run::degrees)),
      quantile(values(unweighted[0], &Run::degrees), 1),
      quantile(values(unweighted[1], &Run::degrees), 1));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(
      argc, argv, "registration_gnc",
      "Thesis figures 6.2, 6.3, 6.5-6.10 and C.1-C.5: graduated non-convexity by "
      "the thesis' literal rule, by the corrected one, and without rejection.",
      experiment_gnc);
}
