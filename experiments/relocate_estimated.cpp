// SPDX-License-Identifier: Apache-2.0
// The relocation policy given the object's place as touch has it, beside the true one.
#include <fmt/format.h>

#include <algorithm>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "palpate/tasks/relocate/relocation.hpp"

namespace {

using namespace palpate;
using relocate::TouchEpisode;

struct Case {
  std::string name;
  bool explore = true, estimate = true;
};

struct Subject {
  std::string object, policy;
};

double median_mm(const std::vector<TouchEpisode>& episodes, double TouchEpisode::*value) {
  std::vector<double> values;
  for (const auto& episode : episodes) values.push_back(1e3 * episode.*value);
  return median(values);
}

std::vector<std::string> row(const Subject& subject, const std::string& name,
                             const std::vector<relocate::Episode>& episodes) {
  const auto summary = relocate::summarize(episodes);
  return {subject.object,
          subject.policy,
          name,
          fmt::format("{}", summary.episodes),
          fmt::format("{:.0f} +- {:.0f}", summary.mean, summary.sd),
          fmt::format("{:.2f}", summary.success_5cm),
          fmt::format("{:.2f}", summary.success_2cm),
          fmt::format("{:.1f}", 1e3 * summary.median_distance)};
}

std::vector<std::string> touch_row(const Subject& subject, const std::string& name,
                                   const std::vector<TouchEpisode>& by_touch) {
  std::vector<relocate::Episode> episodes;
  for (const auto& episode : by_touch) episodes.push_back(episode.episode);
  auto cells = row(subject, name, episodes);
  cells.push_back(fmt::format("{:.1f}", median_mm(by_touch, &TouchEpisode::resting_error)));
  cells.push_back(fmt::format("{:.1f}", median_mm(by_touch, &TouchEpisode::reported_error)));
  cells.push_back(fmt::format("{}", std::ranges::count_if(by_touch, &TouchEpisode::explored)));
  cells.push_back(
      by_touch.front().estimates == 0
          ? ""
          : fmt::format("{:.0f}", median_mm(by_touch, &TouchEpisode::estimate_seconds)));
  return cells;
}

void relocate_estimated(const experiment::Options& options) {
  const std::vector<Subject> subjects = {{"mug", "relocate-best"}, {"box", "relocate-box"}};
  const std::vector<Case> cases = {{"explored, then estimated in the grasp"},
                                   {"explored, then carried by the palm", true, false},
                                   {"rough place, then estimated in the grasp", false, true},
                                   {"rough place, then carried by the palm", false, false}};
  const std::size_t count = options.quick ? 1 : 50;
  experiment::Table table({"object", "policy", "what the policy is given", "episodes", "return",
                           "< 5 cm", "< 2 cm", "final distance mm (median)",
                           "error at first mm (median)", "error at the end mm (median)", "explored",
                           "an estimate takes ms (median)"});
  for (const Subject& subject : subjects) {
    relocate::TaskOptions task;
    task.object = subject.object;
    const auto policy = relocate::load_policy(asset(fmt::format("models/{}.json", subject.policy)));
    auto truth = row(subject, "true place",
                     relocate::rollout(relocate::make_model(task), *policy, {}, options.seed, count,
                                       options.threads));
    truth.insert(truth.end(), {"0", "0", "", ""});
    table.add_row(truth);
    for (const Case& what : options.quick ? std::vector<Case>{cases[2]} : cases) {
      relocate::RelocationOptions relocation;
      relocation.explore = what.explore;
      relocation.tracking.estimate = what.estimate;
      const auto by_touch = relocate::Relocation(task, relocation)
                                .run_all(*policy, {}, options.seed, count, options.threads);
      table.add_row(touch_row(subject, what.name, by_touch));
    }
  }
  table.publish(options, "relocate_estimated", "Relocation by touch, faithful solver");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "relocate_estimated",
                         "The relocation policy given the object's place as touch has it",
                         relocate_estimated);
}
