// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "common.hpp"
#include "eval_faults.hpp"
#include "hand_option.hpp"
#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/evaluation.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "place_report.hpp"
#include "progress_bar.hpp"
#include "terminal.hpp"
#include "trial_records.hpp"
#include "trials_file.hpp"

namespace palpate::app {
namespace {

using evaluation::ObjectSummary;
using nlohmann::json;

struct EvalArguments {
  CommonOptions common;
  bool resume = false;
  std::vector<std::string> objects = {"mug", "bottle", "box", "bracket", "bunny"};
  std::size_t trials = 30;
  std::string place, hand;
  std::vector<std::string> faults;
  bool campaign = false;
};

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

/// Fingerprint of all that decides how a trial goes, but for its number.
std::string configuration_of(const EvalArguments& arguments,
                             const evaluation::TrialOptions& options,
                             const std::vector<geometry::KnownObject>& objects) {
  std::string text = config_header(arguments.common) + to_toml(options);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const auto& vertices = objects[i].mesh.vertices;
    text += fmt::format("{}:{}\n", arguments.objects[i].size(), arguments.objects[i]);
    text.append(reinterpret_cast<const char*>(vertices.data()),
                vertices.size() * sizeof vertices[0]);
  }
  return content_hash(text);
}

/// What an evaluation keeps in its folder, from which it goes on where it was interrupted.
struct EvalOutput {
  EvalOutput(const EvalArguments& arguments, const evaluation::TrialOptions& options,
             const std::vector<geometry::KnownObject>& objects)
      : folder(arguments.common.out, kept_by_force(arguments), arguments.common.force),
        records(begin(), configuration_of(arguments, options, objects)),
        table(folder.path() / "trials.csv", !options.place.target.empty()) {
    write_file_atomically(folder.path() / "config.toml",
                          config_header(arguments.common) + to_toml(options));
    std::filesystem::remove(folder.path() / "eval.json");  // of fewer trials
  }

  void add(const std::string& object, std::uint64_t seed, const evaluation::Trial& trial) {
    const bool known = records.find(object, seed).has_value();
    records.add(object, seed, trial);
    table.add(object, seed, trial);
    if (!known) table.write();
  }

  OutputFolder folder;
  TrialRecords records;
  TrialsFile table;

 private:
  /// Without --force an evaluation goes on, so that nothing is in its way.
  static std::vector<std::string> kept_by_force(const EvalArguments& arguments) {
    if (!arguments.common.force) return {};
    return {"trials.jsonl", "trials.csv", "eval.json", "config.toml"};
  }

  std::filesystem::path begin() const {
    const auto path = folder.path() / "trials.jsonl", rows = folder.path() / "trials.csv";
    if (std::filesystem::exists(path)) return path;
    if (std::filesystem::exists(rows)) {
      throw BadInput(fmt::format(
          "{} is of another run: --force overwrites it, another --out keeps it", rows.string()));
    }
    return path;
  }
};

int eval(EvalArguments arguments) {
  if (arguments.campaign) {
    if (arguments.resume || !arguments.place.empty()) {
      throw BadInput("--faults goes neither with --resume nor with --place");
    }
    return eval_faults(resolve_trial(arguments.common, arguments.hand), arguments.common,
                       arguments.objects, arguments.trials, arguments.faults);
  }
  if (arguments.resume && (arguments.common.out.empty() || arguments.common.force)) {
    throw BadInput("--resume needs the --out of an evaluation, and no --force");
  }
  const auto records = std::filesystem::path(arguments.common.out) / "trials.jsonl";
  if (arguments.resume && !std::filesystem::exists(records)) {
    throw BadInput(fmt::format("{}: there is no evaluation to go on with", records.string()));
  }
  arguments.objects = geometry::expand_object_names(arguments.objects);
  auto options = resolve_trial(arguments.common, arguments.hand);
  if (!arguments.place.empty()) options.place.target = place_text(arguments.place);
  std::optional<Notice> notice(std::in_place, "preparing the objects", arguments.common.quiet);
  std::vector<geometry::KnownObject> objects;
  for (const auto& name : arguments.objects) objects.push_back(geometry::load_known_object(name));
  // A source or target that cannot be is named before anything moves.
  static_cast<void>(options.touch.from_biotacs());
  for (const auto& object : objects) {
    const auto start = evaluation::draw_start(object, options.start, arguments.common.seed);
    evaluation::place_target(object, options.place, arguments.common.seed,
                             static_cast<std::size_t>(start.stable_pose));
  }
  // What the simulator refuses is said before anything is printed or written.
  const simulation::World probe(objects.front(), options.world, arguments.common.seed);
  notice.reset();
  const std::filesystem::path folder = arguments.common.out;
  std::optional<EvalOutput> output;
  if (!folder.empty()) output.emplace(arguments, options, objects);

  const bool table = !arguments.common.json;
  if (table) {
    fmt::print("{:<10} {:<18} {:<18} {:<18} {:>6} {:>7} {:>7}   {}\n", "object", "lifted",
               "pose right", "coverage*", "modes", "deg", "mm", "failures");
  }
  json report = {{"trials", arguments.trials}, {"seed", arguments.common.seed}};
  std::vector<ObjectSummary> summaries;
  ObjectSummary all;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const geometry::ObjectModel model(objects[i]);
    const ProgressBar bar(arguments.objects[i], arguments.trials, arguments.common.quiet);
    bar.show(0);
    summaries.push_back(evaluation::evaluate(
        model, options, arguments.common.seed, arguments.trials, arguments.common.threads,
        [&](std::size_t done, const evaluation::Trial& trial) {
          bar.show(done);
          evaluation::add_trial(trial, all);
          if (output) output->add(arguments.objects[i], arguments.common.seed + done - 1, trial);
        },
        [&](std::size_t trial) {
          return output ? output->records.find(arguments.objects[i], arguments.common.seed + trial)
                        : std::nullopt;
        }));
    report["objects"][arguments.objects[i]] = summary_json(summaries.back());
    if (table) print_row(arguments.objects[i], summaries.back());
  }
  report["all"] = summary_json(all);
  report["all"].erase("symmetry_order");
  if (table) {
    print_row("all", all);
    fmt::print("rates over all trials with 95 % Wilson intervals; * of the lifted\n");
    if (!options.place.target.empty()) print_places(arguments.objects, summaries, all);
  } else {
    fmt::print("{}\n", report.dump(2));
  }
  if (output) {
    output->table.write();
    write_file_atomically(folder / "eval.json", report.dump(2) + "\n");
  }
  return kDone;
}

}  // namespace

void add_eval(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<EvalArguments>();
  auto& command = *program.add_subcommand("eval", "Repeat the pick over seeds and report rates");
  command
      .add_option("--object", arguments->objects,
                  "built-in objects, mesh files, generated:SEED or generated:A-B")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--trials", arguments->trials, "picks per object")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command.add_flag("--resume", arguments->resume,
                   "continue the evaluation in DIR; never start one");
  auto* const faults =
      command
          .add_option(
              "--faults", arguments->faults,
              "repeat the picks with each of these faults of the hand, injected at a random "
              "time, and with none; without a list, with all faults (docs/safety.md)")
          ->delimiter(',')
          ->expected(0, 100);
  add_place_option(command, arguments->place);
  add_hand_option(command, arguments->hand);
  add_common_options(command, arguments->common);
  command.footer(
      "Trial i of every object has the seed SEED + i. With --out it writes eval.json, config.toml "
      "and,\n"
      "as they finish, one row per trial in trials.csv and its details in trials.jsonl into DIR. "
      "The\n"
      "same command continues an interrupted run, with the same result bit for bit; a command "
      "with\n"
      "other settings is refused, unless --force starts over.\n\nExamples:\n"
      "  palpate eval --object mug,box --trials 30 --threads 2 --seed 9000\n"
      "  palpate eval --object generated:9000-9099 --trials 3 --seed 9000\n"
      "  palpate eval --object bunny --trials 10 --set attempts=1 --json\n"
      "  palpate eval --object box,mug --trials 5 --faults load_nan,finger_silent --json\n"
      "  palpate eval --place random --trials 20 --seed 9000\n"
      "  palpate eval --object box --place stable_pose --trials 10 --seed 9000");
  command.callback([arguments, faults, &chosen] {
    arguments->campaign = faults->count() > 0;
    chosen = [arguments] { return eval(*arguments); };
  });
}

}  // namespace palpate::app
