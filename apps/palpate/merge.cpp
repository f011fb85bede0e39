// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "eval_report.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "terminal.hpp"
#include "trial_records.hpp"
#include "trials_file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct MergeArguments {
  CommonOptions common;
  std::vector<std::string> parts;
};

/// What an evaluation writes, too: its configuration and manifest would not be of what is merged.
const std::vector<std::string> kResults = {"trials.jsonl", "trials.csv", "eval.json", "config.toml",
                                           "manifest.json"};

/// The trials of a part: the folder of an evaluation, or the file in it.
TrialRecords read_part(const fs::path& part) {
  if (!fs::is_directory(part)) return TrialRecords::of(part);
  const fs::path file = part / "trials.jsonl";
  if (fs::exists(file)) return TrialRecords::of(file);
  throw BadInput(
      fmt::format("{} has no trials.jsonl: it is not the folder of an evaluation", part.string()));
}

/// @throws BadInput for parts of different evaluations
TrialRecords merged(const std::vector<std::string>& parts) {
  TrialRecords all = read_part(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) {
    all.add_all(read_part(parts[i]));
  }
  return all;
}

/// @throws BadInput unless all trials are there
void check_whole(const TrialRecords& records) {
  const EvalPlan& plan = records.plan();
  std::size_t missing = 0;
  std::string first;
  for (const std::string& object : plan.objects) {
    for (std::size_t number = 0; number < plan.trials; ++number) {
      if (records.find(object, plan.seed + number)) continue;
      if (missing++ == 0) first = fmt::format("{} with seed {}", object, plan.seed + number);
    }
  }
  if (missing == 0) return;
  throw BadInput(fmt::format("{} of {} trials are missing, the first of them {}", missing,
                             plan.objects.size() * plan.trials, first));
}

int merge(const MergeArguments& arguments) {
  const CommonOptions& common = arguments.common;
  const TrialRecords records = merged(arguments.parts);
  check_whole(records);
  const EvalPlan& plan = records.plan();
  std::optional<OutputFolder> folder;
  std::optional<TrialRecords> lines;
  std::optional<TrialsFile> table;
  if (!common.out.empty()) {
    folder.emplace(common.out, kResults, common.force);
    lines.emplace(folder->path() / "trials.jsonl", plan);
    table.emplace(folder->path() / "trials.csv", plan.place);
  }
  EvalReport report(plan, common.json);
  for (std::size_t i = 0; i < plan.objects.size(); ++i) {
    evaluation::ObjectSummary summary;
    summary.symmetry_order = plan.symmetry_orders.at(i);
    for (std::uint64_t seed = plan.seed; seed < plan.seed + plan.trials; ++seed) {
      const evaluation::Trial trial = records.find(plan.objects[i], seed).value();
      evaluation::add_trial(trial, summary);
      report.add(trial);
      if (lines) lines->add(plan.objects[i], seed, trial);
      if (table) table->add(plan.objects[i], seed, trial);
    }
    report.end_object(std::move(summary));
  }
  const auto summary = report.finish();
  if (table) table->write();
  if (!folder) return kDone;
  write_file_atomically(folder->path() / "eval.json", json_text(summary));
  if (!plan.repetition.empty()) print_next(common, repetition_text(plan.repetition));
  return kDone;
}

}  // namespace

void add_merge(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<MergeArguments>();
  auto& command = *program.add_subcommand(
      "merge", "Merge the shards of an evaluation into the report of a single run");
  command
      .add_option("part", arguments->parts,
                  "folders that `palpate eval --shard` wrote, or their trials.jsonl")
      ->required();
  add_common_options(command, arguments->common, kOut);
  command.footer(
      "The report, and eval.json and trials.csv in DIR, are those of the evaluation in one run,\n"
      "bit for bit. Exit code 3: parts of different evaluations, trials that are missing, or\n"
      "trials on which two parts disagree.\n\n"
      "Examples:\n"
      "  palpate merge part1 part2 part3 --json\n"
      "  palpate merge part*/trials.jsonl --out whole");
  command.callback([arguments, &chosen] { chosen = [arguments] { return merge(*arguments); }; });
}

}  // namespace palpate::app
