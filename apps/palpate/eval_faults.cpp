// SPDX-License-Identifier: Apache-2.0
#include "eval_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <utility>

#include "earlier_results.hpp"
#include "fingerprint.hpp"
#include "manifest.hpp"
#include "object_option.hpp"
#include "palpate/core/durable_file.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/fault_campaign.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "palpate/recording/json_text.hpp"
#include "progress_bar.hpp"
#include "rate_text.hpp"

namespace palpate::app {
namespace {

using evaluation::FaultSummary;
using hand::InjectedFault;
using nlohmann::json;

json summary_json(const FaultSummary& summary) {
  return {{"trials", summary.trials},
          {"lifted", rate(summary.lifted, summary.trials)},
          {"pose_ok", rate(summary.pose_ok, summary.trials)},
          {"confident_wrong", rate(summary.confident_wrong, summary.trials)},
          {"overloaded", summary.overloaded},
          {"crushed", summary.crushed},
          {"crashed", summary.crashed},
          {"peak_load", summary.peak_load},
          {"peak_tip_force", summary.peak_tip_force},
          {"longest_stop", summary.longest_stop},
          {"stopped", summary.stopped},
          {"survived", summary.survived}};
}

/// What summary_json() made.
FaultSummary summary_from(const json& row) {
  FaultSummary summary;
  summary.trials = row.at("trials").get<std::size_t>();
  const auto count = [&](const char* key) {
    return static_cast<std::size_t>(
        std::lround(row.at(key).get<double>() * static_cast<double>(summary.trials)));
  };
  summary.lifted = count("lifted");
  summary.pose_ok = count("pose_ok");
  summary.confident_wrong = count("confident_wrong");
  row.at("overloaded").get_to(summary.overloaded);
  row.at("crushed").get_to(summary.crushed);
  row.at("crashed").get_to(summary.crashed);
  row.at("peak_load").get_to(summary.peak_load);
  row.at("peak_tip_force").get_to(summary.peak_tip_force);
  row.at("longest_stop").get_to(summary.longest_stop);
  row.at("stopped").get_to(summary.stopped);
  row.at("survived").get_to(summary.survived);
  return summary;
}

/// The rows that an interrupted campaign of the same configuration has finished.
json finished_rows(const std::filesystem::path& path, const std::string& configuration) {
  return read_earlier(path, [&] {
    const json report = recording::parse_json(read_file(path));
    expect_same_settings(path, report.at("configuration") == configuration);
    const auto built_from = report.value("commit", std::string("an unknown commit"));
    if (built_from != commit()) {
      throw BadInput(fmt::format("{} is of a program built from {}, not {}: use another --out",
                                 path.string(), built_from, commit()));
    }
    return report.at("faults");
  });
}

/// Fingerprint of all that decides how the trials go.
std::string configuration_of(const CommonOptions& common, const evaluation::TrialOptions& options,
                             const std::vector<std::string>& names,
                             const std::vector<geometry::ObjectModel>& models, std::size_t trials) {
  std::vector<NamedObject> objects;
  for (std::size_t i = 0; i < names.size(); ++i) objects.push_back({names[i], &models[i].object()});
  return fmt::format("{} of {} trials from seed {}", trials_fingerprint(common, options, objects),
                     trials, common.seed);
}

void print_heading() {
  fmt::print("{:<17} {:>6}  {:<18} {:<18} {:>6} {:>7} {:>7} {:>8} {:>8} {:>8}   {:<24} {}\n",
             "fault", "trials", "lifted", "pose right", "wrong*", "crashed", "crushed", "mount N",
             "tip N", "after s", "the robot stopped for", "it went on with");
}

void print_row(std::string_view name, const FaultSummary& summary) {
  fmt::print(
      "{:<17} {:>6}  {:<18} {:<18} {:>6} {:>7} {:>7} {:>8.1f} {:>8.1f} {:>8.2f}   {:<24} {}\n",
      name, summary.trials, rate_text(summary.lifted, summary.trials),
      rate_text(summary.pose_ok, summary.trials), summary.confident_wrong, summary.crashed,
      summary.crushed, summary.peak_load, summary.peak_tip_force, summary.longest_stop,
      counts_text(summary.stopped), counts_text(summary.survived));
  std::fflush(stdout);
}

/// None at first, to compare with.
std::vector<InjectedFault> campaign_of(const std::vector<std::string>& names) {
  std::vector<InjectedFault> faults = {InjectedFault::none};
  const auto add = [&](std::string_view name) {
    const InjectedFault fault = hand::injected_fault(name);
    if (std::find(faults.begin(), faults.end(), fault) == faults.end()) faults.push_back(fault);
  };
  for (const auto& name : names) add(name);
  if (names.empty()) {
    for (const auto name : hand::kInjectedFaultNames) add(name);
  }
  return faults;
}

}  // namespace

int eval_faults(const evaluation::TrialOptions& options, const CommonOptions& common,
                const std::vector<std::string>& objects, std::size_t trials,
                const std::vector<std::string>& faults, bool resume) {
  const auto campaign = campaign_of(faults);
  const auto names = geometry::expand_object_names(objects);
  require_distinct(names);  // its trials would count twice
  std::vector<geometry::ObjectModel> models;
  for (const auto& name : names) models.emplace_back(geometry::load_known_object(name));
  // What no trial can be of is no crash of each.
  for (const auto& model : models) {
    evaluation::check_trial(model.object(), options, common.seed);
  }
  const auto output =
      resume ? std::make_unique<OutputFolder>(common.out, std::vector<std::string>(), false)
             : claim_output(common, {"faults.json"});
  const auto path = std::filesystem::path(common.out) / "faults.json";
  const std::string configuration = configuration_of(common, options, names, models, trials);
  json report = {{"trials", trials},
                 {"seed", common.seed},
                 {"configuration", configuration},
                 {"commit", commit()},
                 {"faults", resume ? finished_rows(path, configuration) : json::object()}};
  if (!common.json) print_heading();
  for (const InjectedFault fault : campaign) {
    const std::string name(hand::to_string(fault));
    if (report["faults"].contains(name)) {
      if (!common.json) print_row(name, summary_from(report["faults"][name]));
      continue;
    }
    const ProgressBar bar(name, trials * models.size(), common.quiet);
    FaultSummary sum;
    for (const auto& model : models) {
      const std::size_t before = sum.trials;
      evaluation::add(
          evaluation::evaluate_fault(model, options, fault, common.seed, trials, common.threads,
                                     [&](std::size_t done) { bar.show(before + done); }),
          sum);
    }
    report["faults"][name] = summary_json(sum);
    if (!common.json) print_row(name, sum);
    if (output) write_file_atomically(path, json_text(report));
  }
  if (common.json) print_json(report);
  if (!common.json) fmt::print("* wrong with a stated probability above 0.9\n");
  return kDone;
}

}  // namespace palpate::app
