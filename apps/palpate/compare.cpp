// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "common.hpp"
#include "palpate/core/file.hpp"
#include "palpate/numerics/hypothesis_tests.hpp"
#include "palpate/plotting/plot.hpp"
#include "relocate_arguments.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

constexpr std::size_t kHistogramBins = 20;

struct CompareArguments {
  CommonOptions common;
  std::string a, b;
  std::size_t episodes = 100;
};

/// Returns of A and B, and whether value i of both is of the same start.
struct TwoSamples {
  std::vector<double> a, b;
  bool paired = false;
};

TwoSamples gather(const CompareArguments& arguments) {
  const auto options = resolve<RelocateOptions>(arguments.common);
  const auto sample = [&](const std::string& name) {
    if (!is_policy(name)) return read_returns(name);
    const auto policy = find_policy(name);
    return relocate::returns(relocate::rollout(relocate::make_model(options.task), *policy,
                                               options.episode, arguments.common.seed,
                                               arguments.episodes, arguments.common.threads));
  };
  return {sample(arguments.a), sample(arguments.b),
          is_policy(arguments.a) && is_policy(arguments.b)};
}

json test_json(const numerics::TestResult& test) {
  return {{"statistic", test.statistic}, {"p", test.p}};
}

std::vector<double> differences(const TwoSamples& samples) {
  std::vector<double> result;
  for (std::size_t i = 0; i < samples.a.size(); ++i) result.push_back(samples.a[i] - samples.b[i]);
  return result;
}

json comparison_json(const numerics::Comparison& c, const TwoSamples& samples) {
  json report = {
      {"normality", {{"a", test_json(c.normality_a)}, {"b", test_json(c.normality_b)}}},
      {"bartlett_p", c.bartlett.p},
      {"anova_p", c.anova.p},
      {"welch_p", c.welch.p},
      {"mann_whitney_p", c.mann_whitney.p},
      {"effect_hedges_g", c.effect},
      {"difference",
       {{"mean", c.difference}, {"ci95", {c.difference_ci95.low, c.difference_ci95.high}}}},
      {"mean", {{"a", mean(samples.a)}, {"b", mean(samples.b)}}},
      {"valid_test", c.valid_test},
      {"reason", c.reason}};
  if (samples.paired) {
    const Interval paired = mean_interval(differences(samples));
    report["paired_difference_ci95"] = {paired.low, paired.high};
  }
  return report;
}

plotting::Plot histogram_plot(const TwoSamples& samples) {
  const auto [low_a, high_a] = std::minmax_element(samples.a.begin(), samples.a.end());
  const auto [low_b, high_b] = std::minmax_element(samples.b.begin(), samples.b.end());
  const double low = std::min(*low_a, *low_b), high = std::max(*high_a, *high_b);
  plotting::Plot plot;
  plot.title = "Returns";
  plot.x.label = "return";
  plot.y.label = "share of episodes";
  const auto outline = [&](const char* name, const std::vector<double>& values) {
    const auto counts = histogram(values, low, high, kHistogramBins);
    plotting::LineSeries line{name, {}, {}};
    for (std::size_t i = 0; i < kHistogramBins; ++i) {
      for (const std::size_t edge : {i, i + 1}) {
        line.x.push_back(low + (high - low) * static_cast<double>(edge) / kHistogramBins);
        line.y.push_back(static_cast<double>(counts[i]) / static_cast<double>(values.size()));
      }
    }
    plot.series.emplace_back(line);
  };
  outline("A", samples.a);
  outline("B", samples.b);
  return plot;
}

plotting::Plot normal_plots(const TwoSamples& samples) {
  plotting::Plot plot;
  plot.title = "Normal plot";
  plot.x.label = "quantile of a standard normal";
  plot.y.label = "return";
  for (const auto& [name, values] : {std::pair{"A", &samples.a}, {"B", &samples.b}}) {
    const auto points = numerics::normal_plot(*values);
    plot.series.emplace_back(plotting::ScatterSeries{name, points.quantiles, points.values});
  }
  return plot;
}

void print_table(const numerics::Comparison& c, const TwoSamples& samples) {
  const auto row = [](const char* name, const numerics::TestResult& test, const char* what) {
    fmt::print("{:<15} {:>10.4g}   p = {:<10.3g} {}\n", name, test.statistic, test.p, what);
  };
  fmt::print("A {:.1f}, B {:.1f}; A - B = {:.1f} [{:.1f}, {:.1f}] (95 %), Hedges' g {:.2f}\n\n",
             mean(samples.a), mean(samples.b), c.difference, c.difference_ci95.low,
             c.difference_ci95.high, c.effect);
  row("Shapiro-Wilk A", c.normality_a, "is A normal?");
  row("Shapiro-Wilk B", c.normality_b, "is B normal?");
  row("Bartlett", c.bartlett, "are the variances equal? (needs normality)");
  row("ANOVA", c.anova, "are the means equal? (needs normality, equal variances)");
  row("Welch", c.welch, "are the means equal? (needs normality)");
  row("Mann-Whitney", c.mann_whitney, "is neither above the other?");
  fmt::print("\nvalid: {}, because {}\n", c.valid_test, c.reason);
  if (samples.paired) {
    const Interval paired = mean_interval(differences(samples));
    fmt::print("paired by their starts: A - B within [{:.1f}, {:.1f}] (95 %)\n", paired.low,
               paired.high);
  }
}

int compare(const CompareArguments& arguments) {
  const auto& common = arguments.common;
  const auto output = claim_output(common, {"compare.json"});
  const TwoSamples samples = gather(arguments);
  const auto comparison =
      numerics::compare_samples(samples.a, samples.b, RandomStream(common.seed, "compare"));
  const json report = comparison_json(comparison, samples);
  if (!common.out.empty()) {
    const std::filesystem::path folder = common.out;
    write_file_atomically(folder / "compare.json", report.dump(2) + "\n");
    write_file_atomically(folder / "histogram.svg", plotting::to_svg(histogram_plot(samples)));
    write_file_atomically(folder / "normal-plot.svg", plotting::to_svg(normal_plots(samples)));
  }
  if (common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    print_table(comparison, samples);
  }
  return kDone;
}

}  // namespace

void add_compare(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<CompareArguments>();
  auto& command = *program.add_subcommand("compare", "Test whether two policies differ");
  const char* const kind = "policy file, name of a shipped policy, or episodes.csv of a rollout";
  command.add_option("A", arguments->a, kind)->required();
  command.add_option("B", arguments->b, kind)->required();
  command.add_option("--episodes", arguments->episodes, "of each policy, on the same starts")
      ->check(CLI::Range(3, 5000))
      ->capture_default_str();
  add_task_option(command);
  add_common_options(command, arguments->common);
  command.footer(
      "Says which of the tests may be believed, and why. With --out the histograms and normal\n"
      "plots go to DIR.\n\n"
      "Examples:\n"
      "  palpate compare relocate-best out/cem/policy.json --episodes 30 --threads 2\n"
      "  palpate compare out/a/episodes.csv out/b/episodes.csv --out out/compare");
  command.callback([arguments, &chosen] { chosen = [arguments] { return compare(*arguments); }; });
}

}  // namespace palpate::app
