// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <ctime>
#include <map>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/plotting/plot.hpp"
#include "tactile/sliding_score.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;
using namespace palpate::tactile;

struct Result {
  SlidingScore score;
  double seconds = 0;
  std::size_t samples = 0;
};

Result slide(const std::string& name, Surface surface, const SlidingOptions& sliding,
             const Options& options) {
  Result result;
  const std::uint64_t seeds = options.quick ? 2 : 20;
  for (std::uint64_t seed = options.seed; seed < options.seed + seeds; ++seed) {
    const RandomStream random(seed);
    const auto path = sliding_path(surface, sliding, random);
    const auto samples = samples_along(path, sliding, random);
    const auto estimator = make_normal_estimator(name);
    const std::clock_t start = std::clock();  // of the processor: others may use it too
    add_score(*estimator, samples, path, sliding.period, result.score);
    result.seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    result.samples += samples.size();
  }
  return result;
}

std::string errors_of(const Result& result) {
  return fmt::format("{:.2f} / {:.1f}", median(result.score.error_deg),
                     quantile(result.score.error_deg, 0.95));
}

std::string nees_of(const Result& result) {
  return result.score.nees.empty() ? "-" : fmt::format("{:.2f}", mean(result.score.nees));
}

/// Medians by surface, one bar an estimator.
std::string figure(const std::map<std::string, std::vector<double>>& medians,
                   const std::string& title) {
  plotting::Plot plot;
  plot.title = title;
  plot.y.label = "median angle error (deg)";
  plot.y.logarithmic = true;
  for (auto name : kSurfaceNames) plot.categories.emplace_back(name);
  for (const std::string& name : normal_estimators()) {
    plot.series.emplace_back(plotting::BarSeries{name, medians.at(name)});
  }
  return plotting::to_svg(plot);
}

void compare(const SlidingOptions& sliding, const std::string& file, const Options& options) {
  Table errors({"estimator", "flat", "edge", "smooth", "corner", "us a sample"});
  Table honesty({"estimator", "flat", "edge", "smooth", "corner", "mean"});
  std::map<std::string, std::vector<double>> medians;
  for (const std::string& name : normal_estimators()) {
    std::vector<std::string> row = {name}, nees = {name};
    double seconds = 0, sum = 0;
    std::size_t samples = 0;
    for (const Surface surface : kSurfaces) {
      const Result result = slide(name, surface, sliding, options);
      row.push_back(errors_of(result));
      nees.push_back(nees_of(result));
      medians[name].push_back(median(result.score.error_deg));
      if (!result.score.nees.empty()) sum += mean(result.score.nees) / 4;
      seconds += result.seconds;
      samples += result.samples;
    }
    row.push_back(fmt::format("{:.1f}", 1e6 * seconds / static_cast<double>(samples)));
    nees.push_back(sum > 0 ? fmt::format("{:.2f}", sum) : "-");
    errors.add_row(row);
    if (sum > 0) honesty.add_row(nees);
  }
  const auto noise = fmt::format("point noise {} mm", 1e3 * sliding.point_noise);
  errors.publish(options, file, fmt::format("Angle error, median / p95 deg; {}", noise));
  honesty.publish(options, file + "_nees",
                  fmt::format("Normalised error squared, mean (honest: 2); {}", noise));
  publish_figure(options, file, figure(medians, "Sliding over four surfaces, " + noise));
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "touch_benchmark",
             "Normals of four synthetic surfaces by every estimator: errors, honesty and time",
             [](const Options& options) {
               compare({}, "noise_0.1mm", options);
               compare({.point_noise = 5e-4}, "noise_0.5mm", options);
             });
}
