// SPDX-License-Identifier: Apache-2.0
// What was touched and gripped in picks, given to an estimator whose candidates lack the object,
// and to one whose candidates hold it.
#include <fmt/format.h>

#include <array>

#include "experiment.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/estimation/estimate.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/geometry/objects/known_object.hpp"

namespace {

using namespace palpate;
using estimation::Candidates;
using estimation::PoseEstimator;

constexpr std::array kNames = {"box", "mug", "bracket", "bottle"};
constexpr std::size_t kPicks = 8;

using Models = std::vector<geometry::ObjectModel>;

evaluation::TrialOptions trial_options(bool quick) {
  if (!quick) return {};
  evaluation::TrialOptions options = evaluation::TrialOptions::ideal();
  options.pick.explore.touches = options.pick.explore.max_touches = 4;
  options.pick.palpation.table_touches = 0;
  options.pick.estimation.search.proposals = 20000;
  options.pick.estimation.search.particles = 400;
  return options;
}

std::vector<std::string> row_of(const Models& models, std::uint64_t seed, bool quick) {
  const std::size_t picked = seed % models.size();
  const geometry::ObjectModel& model = models[picked];
  const evaluation::TrialOptions options = trial_options(quick);
  simulation::World world(model.object(), options.world, seed);
  const auto waiting = evaluation::waiting_command(world.hand_model());
  world.reset(evaluation::draw_start(model.object(), options.start, seed), waiting);
  skills::Executor robot(world.hand(), world.hand_model(), waiting);
  const bool held = skills::pick(robot, model, options.pick, seed).held;
  std::vector<std::string> row = {fmt::format("{}", seed), kNames[picked], held ? "yes" : "no"};
  if (!held) {
    row.insert(row.end(), {"", "", ""});
    return row;
  }
  Candidates all, others;
  for (const auto& candidate : models) {
    all.push_back(&candidate);
    if (&candidate != &model) others.push_back(&candidate);
  }
  const auto held_at = robot.log().at(estimation::TouchEvent::held);
  PoseEstimator without(others, options.pick.estimation, seed);
  const auto wrong = without.held(robot.model(), robot.log(), held_at);
  PoseEstimator with(all, options.pick.estimation, seed);
  with.held(robot.model(), robot.log(), held_at);
  row.push_back(fmt::format("{:.3f}", localization::best_probability(wrong.posterior)));
  row.push_back(fmt::format("{:.3f}", without.probabilities().other));
  row.push_back(fmt::format("{:.3f}", with.probabilities().candidates[picked]));
  return row;
}

void left_out(const experiment::Options& options) {
  Models models;
  for (const char* name : kNames) models.emplace_back(geometry::load_known_object(name));
  std::vector<std::vector<std::string>> rows(options.quick ? 1 : kPicks);
  parallel_for(rows.size(), options.threads,
               [&](std::size_t i) { rows[i] = row_of(models, options.seed + i, options.quick); });
  experiment::Table table({"seed", "object", "held", "wrong candidate, stated", "other object",
                           "object among the candidates"});
  for (auto& row : rows) table.add_row(std::move(row));
  table.publish(options, "candidates_left_out", "the object is left out of the candidates");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "candidates_left_out",
                         "Probability stated for a wrong object and pose where the candidates lack "
                         "the object that was picked, and for the object where they hold it",
                         left_out);
}
