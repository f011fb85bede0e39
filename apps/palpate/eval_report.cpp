// SPDX-License-Identifier: Apache-2.0
#include "eval_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "object_option.hpp"
#include "palpate/core/statistics.hpp"
#include "place_report.hpp"
#include "rate_text.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using evaluation::ObjectSummary;
using nlohmann::json;

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
          {"placed_of_certain", rate(summary.place.certain_placed, summary.place.certain)},
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

void print_row(const std::string& name, std::size_t width, const ObjectSummary& summary) {
  fmt::print("{:<{}} {:<18} {:<18} {:<18} {:>6} {:>7} {:>7}   {}\n", name, width,
             rate_text(summary.lifted, summary.trials), rate_text(summary.pose_ok, summary.trials),
             rate_text(summary.covered, summary.lifted), median_text(summary.modes),
             median_text(summary.rotation_error_deg), median_text(summary.translation_error_mm),
             counts_text(summary.failures));
  std::fflush(stdout);
}

void print_places(const std::vector<std::string>& names, std::size_t width,
                  const std::vector<ObjectSummary>& summaries, const ObjectSummary& all) {
  fmt::print("\n{}\n", place_heading(width));
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    fmt::print("{}\n", place_row(names[i], width, summaries[i].place, summaries[i].trials));
  }
  fmt::print("{}\n* of the certain\n\n{}", place_row("all", width, all.place, all.trials),
             phases_table(all.phases));
}

}  // namespace

std::string repetition_text(const std::string& command) {
  return command + " repeats the first trial, and draws it";
}

EvalReport::EvalReport(const EvalPlan& plan, bool json)
    : plan_(plan), json_(json), report_({{"trials", plan.trials}, {"seed", plan.seed}}) {
  if (json_) return;
  for (std::size_t i = 0; i < plan.repairs.size(); ++i) {
    print_repairs(plan.objects.at(i), plan.repairs[i]);
  }
  for (const auto& name : plan.objects) name_width_ = std::max(name_width_, name.size());
  fmt::print("{:<{}} {:<18} {:<18} {:<18} {:>6} {:>7} {:>7}   {}\n", "object", name_width_,
             "lifted", "pose right", "coverage*", "modes", "deg", "mm", "failures");
}

void EvalReport::add(const evaluation::Trial& trial) { evaluation::add_trial(trial, all_); }

void EvalReport::end_object(ObjectSummary summary) {
  const std::string& name = plan_.objects.at(summaries_.size());
  report_["objects"][name] = summary_json(summary);
  report_["objects"][name]["repairs"] = plan_.repairs.at(summaries_.size());
  if (!json_) print_row(name, name_width_, summary);
  summaries_.push_back(std::move(summary));
}

json EvalReport::finish() {
  report_["all"] = summary_json(all_);
  report_["all"].erase("symmetry_order");
  if (json_) {
    print_json(report_);
    return report_;
  }
  print_row("all", name_width_, all_);
  fmt::print("rates over all trials with 95 % Wilson intervals; * of the lifted\n");
  if (plan_.place) print_places(plan_.objects, name_width_, summaries_, all_);
  return report_;
}

}  // namespace palpate::app
