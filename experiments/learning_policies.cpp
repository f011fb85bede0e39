// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/numerics/hypothesis_tests.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace {

using namespace palpate;
using experiment::Options;
using relocate::Episode;

struct Condition {
  std::string name;
  relocate::TaskOptions task;
  relocate::EpisodeOptions episode;
};

struct Contender {
  std::string name;
  std::unique_ptr<relocate::Policy> policy;
};

std::optional<std::filesystem::path> data_folder() {
  const char* const folder = std::getenv("PALPATE_DATA");
  if (!folder) return {};
  return folder;
}

std::vector<Contender> contenders() {
  std::vector<Contender> result;
  for (const char* name : {"relocate-best", "relocate-memoryless", "relocate-box"}) {
    result.push_back({name, relocate::load_policy(asset(fmt::format("models/{}.json", name)))});
  }
  if (const auto data = data_folder()) {
    result.push_back(
        {"published", relocate::load_policy(*data / "relocate_mug_published_policy.json")});
  }
  return result;
}

std::vector<Condition> conditions() {
  std::vector<Condition> result(6);
  result[0].name = "mug of primitives";
  result[1].name = "scale 0.25..1";
  result[1].episode.scale_high = 1;
  result[2].name = "scale 1";
  result[2].episode.scale_low = result[2].episode.scale_high = 1;
  result[3].name = "mug of 0.417 kg";
  result[3].task.mass_scale = 0.417 / 0.301;
  result[4].name = "friction x 0.7";
  result[4].task.friction_scale = 0.7;
  result[5].name = "box";
  result[5].task.object = "box";
  if (const auto data = data_folder()) {
    Condition ycb;
    ycb.name = "YCB mug";
    ycb.task.object = fmt::format("ycb-mug:{}", (*data / "ycb/025_mug.ply").string());
    result.insert(result.begin() + 1, ycb);
  }
  return result;
}

void add_row(experiment::Table& table, const Condition& condition, const std::string& name,
             const std::vector<Episode>& episodes) {
  const auto s = relocate::summarize(episodes);
  table.add_row({condition.name, name, fmt::format("{}", s.episodes),
                 fmt::format("{:.0f} +- {:.0f}", s.mean, s.sd),
                 fmt::format("{:.3f}", s.success_10cm), fmt::format("{:.3f}", s.success_5cm),
                 fmt::format("{:.3f}", s.success_2cm)});
}

std::string paired(const std::vector<Episode>& a, const std::vector<Episode>& b) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) differences.push_back(a[i].total - b[i].total);
  const auto interval = mean_interval(differences);
  return fmt::format("{:+.0f} [{:+.0f}, {:+.0f}]", mean(differences), interval.low, interval.high);
}

/// Figures 7.6 and 7.8: histograms and normal plots of the returns.
void publish_distributions(const Options& options, const std::vector<Contender>& policies,
                           const std::vector<std::vector<Episode>>& episodes) {
  constexpr std::size_t kBins = 20;
  constexpr double kLow = -500, kHigh = 6500;
  plotting::Plot figure, normal;
  figure.title = "Returns on the mug of primitives";
  figure.x.label = "return";
  figure.y.label = "share of episodes";
  normal.title = "Normal plot of the returns";
  normal.x.label = "quantile of a standard normal";
  normal.y.label = "return";
  for (std::size_t i = 0; i < policies.size(); ++i) {
    const auto totals = relocate::returns(episodes[i]);
    const auto counts = histogram(totals, kLow, kHigh, kBins);
    plotting::LineSeries outline{policies[i].name, {}, {}};
    for (std::size_t k = 0; k < kBins; ++k) {
      for (const std::size_t edge : {k, k + 1}) {
        outline.x.push_back(kLow + (kHigh - kLow) * static_cast<double>(edge) / kBins);
        outline.y.push_back(static_cast<double>(counts[k]) / static_cast<double>(totals.size()));
      }
    }
    figure.series.emplace_back(outline);
    const auto points = numerics::normal_plot(totals);
    normal.series.emplace_back(
        plotting::ScatterSeries{policies[i].name, points.quantiles, points.values});
  }
  publish_figure(options, "figure-7-6-histograms", plotting::to_svg(figure));
  publish_figure(options, "figure-7-8-normal-plots", plotting::to_svg(normal));
}

void run_all(const Options& options) {
  const auto policies = contenders();
  auto all = conditions();
  if (options.quick) all.resize(1);
  const std::size_t count = options.quick ? 3 : 300;
  experiment::Table table(
      {"condition", "policy", "episodes", "return", "< 10 cm", "< 5 cm", "< 2 cm"});
  experiment::Table differences({"condition", "policy", "return - published, paired [95 %]"});
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto model = relocate::make_model(all[k].task);
    std::vector<std::vector<Episode>> episodes;
    for (const auto& contender : policies) {
      episodes.push_back(relocate::rollout(model, *contender.policy, all[k].episode, options.seed,
                                           count, options.threads));
      add_row(table, all[k], contender.name, episodes.back());
    }
    if (k == 0) publish_distributions(options, policies, episodes);
    if (policies.back().name != "published") continue;
    for (std::size_t i = 0; i + 1 < policies.size(); ++i) {
      differences.add_row({all[k].name, policies[i].name, paired(episodes[i], episodes.back())});
    }
  }
  table.publish(options, "policies", "Policies on the faithful model, 99 steps");
  differences.publish(options, "differences", "Differences from the published policy");
}

}  // namespace

int main(int argc, char** argv) {
  return palpate::experiment::run(
      argc, argv, "learning_policies",
      "The shipped relocate policies beside the published one (figures 7.6 and 7.8).", run_all);
}
