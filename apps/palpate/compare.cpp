// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/numerics/hypothesis_tests.hpp"
#include "palpate/numerics/interquartile_mean.hpp"
#include "palpate/plotting/plot.hpp"
#include "relocate_arguments.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

constexpr std::size_t kHistogramBins = 20;
constexpr int kResamples = 10000;
constexpr const char* kHistogram = "histogram.svg";
constexpr const char* kNormalPlot = "normal-plot.svg";
constexpr double kMinWidth = 1;  // of a histogram, if all values are equal

struct CompareArguments {
  CommonOptions common;
  std::string a, b;
  std::size_t episodes = 100;
};

/// What is compared, and whether value i of both is of the same start: the returns of episodes, or,
/// of several trainings, the mean return of each.
struct TwoSamples {
  std::vector<double> a, b;
  bool paired = false;
  const char* unit = "episode";
};

/// A policy, or the returns of its episodes where these were run before.
struct Candidate {
  std::unique_ptr<relocate::Policy> policy;
  std::vector<double> returns;
};

std::vector<std::string> names_in(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream words(list);
  for (std::string name; std::getline(words, name, ',');) {
    if (name.empty()) throw BadInput(fmt::format("an empty name in '{}'", list));
    if (std::ranges::find(names, name) != names.end()) {
      throw BadInput(fmt::format("{} is given twice, and is one training", name));
    }
    names.push_back(name);
  }
  return names;
}

/// Reads a file once, for it may be a pipe.
std::vector<Candidate> load_candidates(const std::vector<std::string>& names) {
  std::vector<Candidate> candidates;
  for (const auto& name : names) {
    is_policy(name) ? candidates.push_back({find_policy(name), {}})
                    : candidates.push_back({nullptr, read_returns(name)});
  }
  return candidates;
}

/// The candidates for A and B.
struct Candidates {
  std::vector<Candidate> a, b;
};

/// Before any episode is run. @throws BadInput for a name that is none, or too few names
Candidates load_candidates(const CompareArguments& arguments) {
  const auto a = names_in(arguments.a), b = names_in(arguments.b);
  const auto fewer = std::min(a.size(), b.size()), more = std::max(a.size(), b.size());
  if (fewer < 2 && more > 1) {
    throw BadInput(fmt::format("{} trainings against {}: at least two of each, or one file each",
                               a.size(), b.size()));
  }
  return {load_candidates(a), load_candidates(b)};
}

std::vector<double> episode_returns(const CompareArguments& arguments,
                                    const RelocateOptions& options, const Candidate& candidate) {
  if (!candidate.policy) return candidate.returns;
  return relocate::returns(relocate::rollout(relocate::make_model(options.task), *candidate.policy,
                                             options.episode, arguments.common.seed,
                                             arguments.episodes, arguments.common.threads));
}

std::vector<double> training_means(const CompareArguments& arguments,
                                   const RelocateOptions& options,
                                   const std::vector<Candidate>& candidates) {
  std::vector<double> means;
  for (const Candidate& candidate : candidates) {
    means.push_back(mean(episode_returns(arguments, options, candidate)));
  }
  return means;
}

TwoSamples gather(const CompareArguments& arguments, const RelocateOptions& options,
                  const Candidates& candidates) {
  const auto& [a, b] = candidates;
  if (a.size() != 1 || b.size() != 1) {
    return {training_means(arguments, options, a), training_means(arguments, options, b), false,
            "training"};
  }
  return {episode_returns(arguments, options, a.front()),
          episode_returns(arguments, options, b.front()), a.front().policy && b.front().policy};
}

json test_json(const std::optional<numerics::TestResult>& test) {
  if (!test) return nullptr;
  return {{"statistic", test->statistic}, {"p", test->p}};
}

json p_json(const std::optional<numerics::TestResult>& test) {
  return test ? json(test->p) : json(nullptr);
}

json center_json(const std::vector<double>& values, RandomStream random) {
  const Interval ci = numerics::bootstrap_interquartile_mean({values}, kResamples, random);
  return {{"value", numerics::interquartile_mean(values)}, {"ci95", {ci.low, ci.high}}};
}

std::vector<double> differences(const TwoSamples& samples) {
  std::vector<double> result;
  for (std::size_t i = 0; i < samples.a.size(); ++i) result.push_back(samples.a[i] - samples.b[i]);
  return result;
}

json comparison_json(const numerics::Comparison& c, const TwoSamples& samples,
                     const RandomStream& random) {
  json report = {
      {"normality", {{"a", test_json(c.normality_a)}, {"b", test_json(c.normality_b)}}},
      {"bartlett_p", p_json(c.bartlett)},
      {"anova_p", p_json(c.anova)},
      {"welch_p", p_json(c.welch)},
      {"mann_whitney_p", c.mann_whitney.p},
      {"effect_hedges_g", c.effect ? json(*c.effect) : json(nullptr)},
      {"difference",
       {{"mean", c.difference}, {"ci95", {c.difference_ci95.low, c.difference_ci95.high}}}},
      {"unit", samples.unit},
      {"interquartile_mean",
       {{"a", center_json(samples.a, random.fork("a"))},
        {"b", center_json(samples.b, random.fork("b"))}}},
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
  const double low = std::min(*low_a, *low_b);
  const double high = std::max({*high_a, *high_b, low + kMinWidth});
  plotting::Plot plot;
  plot.title = "Returns";
  plot.x.label = "return";
  plot.y.label = fmt::format("share of {}s", samples.unit);
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

void print_centers(const json& report) {
  const auto& of = report["interquartile_mean"];
  const auto text = [](const json& center) {
    return fmt::format("{:.1f} [{:.1f}, {:.1f}]", center["value"].get<double>(),
                       center["ci95"][0].get<double>(), center["ci95"][1].get<double>());
  };
  fmt::print("interquartile mean over {}s: A {}, B {} (95 %)\n", report["unit"].get<std::string>(),
             text(of["a"]), text(of["b"]));
}

void print_table(const numerics::Comparison& c, const TwoSamples& samples, const json& report) {
  const auto row = [](const char* name, const std::optional<numerics::TestResult>& test,
                      const char* what) {
    if (!test) return;
    fmt::print("{:<15} {:>10.4g}   p = {:<10.3g} {}\n", name, test->statistic, test->p, what);
  };
  fmt::print("A {:.1f}, B {:.1f}; A - B = {:.1f} [{:.1f}, {:.1f}] (95 %){}\n", mean(samples.a),
             mean(samples.b), c.difference, c.difference_ci95.low, c.difference_ci95.high,
             c.effect ? fmt::format(", Hedges' g {:.2f}", *c.effect) : "");
  print_centers(report);
  fmt::print("\n");
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

/// Where returns are read, no episode is run.
void refuse_options_of_rollouts(const CompareArguments& arguments, const CLI::App& command) {
  for (const auto& list : {arguments.a, arguments.b}) {
    if (std::ranges::any_of(names_in(list), is_policy)) return;
  }
  for (const char* const option : {"--episodes", "--threads", "--task", "--config", "--set"}) {
    if (command.count(option) == 0) continue;
    throw BadInput(
        fmt::format("{} is of no use: {} and {} are returns of episodes that were run before",
                    option, arguments.a, arguments.b));
  }
}

int compare(const CompareArguments& arguments, const CLI::App& command) {
  const auto& common = arguments.common;
  const auto options = resolve<RelocateOptions>(common);
  const Candidates candidates = load_candidates(arguments);
  const auto output = claim_output(common, {"compare.json", kHistogram, kNormalPlot});
  std::optional<Notice> notice(std::in_place, "running episodes", common.quiet);
  const TwoSamples samples = gather(arguments, options, candidates);
  notice.reset();
  const auto comparison =
      numerics::compare_samples(samples.a, samples.b, RandomStream(common.seed, "compare"));
  const json report =
      comparison_json(comparison, samples, RandomStream(common.seed, "interquartile mean"));
  if (!common.out.empty()) {
    const std::filesystem::path folder = common.out;
    write_file_atomically(folder / "compare.json", json_text(report));
    write_file_atomically(folder / kHistogram, plotting::to_svg(histogram_plot(samples)));
    write_file_atomically(folder / kNormalPlot, plotting::to_svg(normal_plots(samples)));
  }
  if (common.json) {
    print_json(report);
  } else {
    print_table(comparison, samples, report);
  }
  print_next(common,
             common.out.empty()
                 ? given_command(command) + " --out out/compare draws the histograms"
                 : fmt::format("open {} in a browser", quoted(common.out + "/" + kHistogram)));
  return kDone;
}

}  // namespace

std::vector<OptionInfo> compare_option_list() { return list_options(RelocateOptions{}); }

void add_compare(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<CompareArguments>();
  auto& command = *program.add_subcommand("compare", "Test whether two policies differ");
  const char* const kind =
      "policy file, name of a shipped policy, or episodes.csv of a rollout; for several "
      "trainings of one method, separate them by commas";
  command.add_option("A", arguments->a, kind)->required();
  command.add_option("B", arguments->b, kind)->required();
  command
      .add_option("--episodes", arguments->episodes,
                  "episodes of each policy, from the same start states")
      ->check(in_range(3, 5000))
      ->capture_default_str();
  add_task_option(command);
  add_common_options(command, arguments->common);
  command.footer(
      "Reports which of the tests is valid, and why. With several trainings of each method, the "
      "mean\n"
      "return of a training is one sample. With --out the histograms and normal plots go "
      "to\n"
      "DIR.\n\n"
      "Examples:\n"
      "  palpate compare relocate-best out/cem/policy.json --episodes 30 --threads 2\n"
      "  palpate compare out/a/episodes.csv out/b/episodes.csv --out out/compare\n"
      "  palpate compare out/a1/policy.json,out/a2/policy.json "
      "out/b1/policy.json,out/b2/policy.json");
  command.callback([arguments, &command, &chosen] {
    chosen = [arguments, &command] {
      refuse_options_of_rollouts(*arguments, command);
      return compare(*arguments, command);
    };
  });
}

}  // namespace palpate::app
