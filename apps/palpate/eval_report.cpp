// SPDX-License-Identifier: Apache-2.0
#include "eval_report.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "palpate/core/statistics.hpp"
#include "place_report.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using evaluation::ObjectSummary;
using nlohmann::json;

json quantiles_json(const std::vector<double>& values) {
  if (values.empty()) return {{"median", nullptr}, {"p95", nullptr}};
  return {{"median", median(values)}, {"p95", quantile(values, 0.95)}};
}

double rate(std::size_t count, std::size_t trials) {
  return trials == 0 ? 0 : static_cast<double>(count) / static_cast<double>(trials);
}

/// Nothing here depends on how fast the machine is.
json phases_json(const std::map<std::string, evaluation::PhaseSummary>& phases) {
  json all = json::object();
  for (const auto& [name, phase] : phases) {
    all[name] = {{"runs", phase.runs},
                 {"ok", rate(phase.ok, phase.runs)},
                 {"robot_seconds", quantiles_json(phase.robot_seconds)}};
  }
  return all;
}

json median_or_null(const std::vector<double>& values) {
  return values.empty() ? json() : json(median(values));
}

json mean_or_null(const std::vector<double>& values) {
  return values.empty() ? json() : json(mean(values));
}

json summary_json(const ObjectSummary& summary) {
  return {{"trials", summary.trials},
          {"lifted", rate(summary.lifted, summary.trials)},
          {"pose_ok", rate(summary.pose_ok, summary.trials)},
          {"object_ok", rate(summary.object_ok, summary.trials)},
          {"object_certain", rate(summary.object_certain, summary.trials)},
          {"object_ok_of_certain", rate(summary.object_certain_ok, summary.object_certain)},
          {"lifted_at_once", rate(summary.lifted_at_once, summary.trials)},
          {"pose_tight", rate(summary.pose_tight, summary.trials)},
          {"pose_ok_before_lift", rate(summary.pose_ok_before_lift, summary.trials)},
          {"pose_ok_before_probe", rate(summary.pose_ok_before_probe, summary.trials)},
          {"pose_ok_tracked", rate(summary.pose_ok_tracked, summary.trials)},
          {"probed", rate(summary.probed, summary.trials)},
          {"certain", rate(summary.certain, summary.trials)},
          {"mean_probability", mean_or_null(summary.probability)},
          {"confident_wrong", rate(summary.confident_wrong, summary.trials)},
          {"coverage", rate(summary.covered, summary.lifted)},
          {"false_hold", rate(summary.false_hold, summary.trials)},
          {"modes_median", median_or_null(summary.modes)},
          {"placed", rate(summary.place.placed, summary.trials)},
          {"placed_of_certain", rate(summary.place.placed, summary.place.certain)},
          {"place", place_summary_json(summary.place, summary.trials)},
          {"phases", phases_json(summary.phases)},
          {"robot_seconds", quantiles_json(summary.robot_seconds)},
          {"rotation_error_deg", quantiles_json(summary.rotation_error_deg)},
          {"translation_error_mm", quantiles_json(summary.translation_error_mm)},
          {"slip_mm", quantiles_json(summary.slip_mm)},
          {"tip_force", quantiles_json(summary.tip_force)},
          {"explored_motion_mm", quantiles_json(summary.explored_motion_mm)},
          {"failures", summary.failures},
          {"symmetry_order", summary.symmetry_order}};
}

std::string rate_text(std::size_t count, std::size_t trials) {
  if (trials == 0) return "-";
  const auto interval = wilson_interval(count, trials);
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]", rate(count, trials), interval.low, interval.high);
}

std::string median_text(const std::vector<double>& values) {
  return values.empty() ? "-" : fmt::format("{:.1f}", median(values));
}

std::string failures_text(const ObjectSummary& summary) {
  std::string text;
  for (const auto& [phase, count] : summary.failures) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", phase, count);
  }
  return text.empty() ? "-" : text;
}

void print_row(const std::string& name, const ObjectSummary& summary) {
  fmt::print("{:<10} {:<18} {:<18} {:<18} {:>6} {:>7} {:>7}   {}\n", name,
             rate_text(summary.lifted, summary.trials), rate_text(summary.pose_ok, summary.trials),
             rate_text(summary.covered, summary.lifted), median_text(summary.modes),
             median_text(summary.rotation_error_deg), median_text(summary.translation_error_mm),
             failures_text(summary));
  std::fflush(stdout);
}

void print_places(const std::vector<std::string>& names,
                  const std::vector<ObjectSummary>& summaries, const ObjectSummary& all) {
  fmt::print("\n{}\n", place_heading());
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    fmt::print("{}\n", place_row(names[i], summaries[i].place, summaries[i].trials));
  }
  fmt::print("{}\n* of the certain\n\n{}", place_row("all", all.place, all.trials),
             phases_table(all.phases));
}

}  // namespace

EvalReport::EvalReport(const EvalPlan& plan, bool json)
    : plan_(plan), json_(json), report_({{"trials", plan.trials}, {"seed", plan.seed}}) {
  if (json_) return;
  fmt::print("{:<10} {:<18} {:<18} {:<18} {:>6} {:>7} {:>7}   {}\n", "object", "lifted",
             "pose right", "coverage*", "modes", "deg", "mm", "failures");
}

void EvalReport::add(const evaluation::Trial& trial) { evaluation::add_trial(trial, all_); }

void EvalReport::end_object(ObjectSummary summary) {
  const std::string& name = plan_.objects.at(summaries_.size());
  report_["objects"][name] = summary_json(summary);
  if (!json_) print_row(name, summary);
  summaries_.push_back(std::move(summary));
}

json EvalReport::finish() {
  report_["all"] = summary_json(all_);
  report_["all"].erase("symmetry_order");
  if (json_) {
    fmt::print("{}\n", report_.dump(2));
    return report_;
  }
  print_row("all", all_);
  fmt::print("rates over all trials with 95 % Wilson intervals; * of the lifted\n");
  if (plan_.place) print_places(plan_.objects, summaries_, all_);
  return report_;
}

}  // namespace palpate::app
