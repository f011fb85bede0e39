// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cstdio>

#include "common.hpp"
#include "eval_faults.hpp"
#include "eval_output.hpp"
#include "eval_report.hpp"
#include "fingerprint.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "live_view.hpp"
#include "manifest.hpp"
#include "object_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/version.hpp"
#include "palpate/evaluation/evaluation.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "place_report.hpp"
#include "progress_bar.hpp"
#include "terminal.hpp"
#include "trial_records.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

/// A share of all trials, by their number over all objects.
struct Shard {
  std::size_t number = 1, count = 1;

  [[nodiscard]] bool has(std::size_t trial) const { return trial % count == number - 1; }
};

/// @throws BadInput unless it is I/N, 1 <= I <= N
Shard parse_shard(const std::string& text) {
  std::size_t number = 0, count = 0;
  char end = 0;
  const int read = std::sscanf(text.c_str(), "%zu/%zu%c", &number, &count, &end);
  if (read != 2 || number < 1 || number > count || count > 1'000'000) {
    throw BadInput(fmt::format("--shard {}: it is I/N with 1 <= I <= N, as in 3/16", text));
  }
  return {number, count};
}

struct EvalArguments {
  CommonOptions common;
  bool resume = false;
  std::vector<std::string> objects = {"mug", "bottle", "box", "bracket", "duck"};
  std::size_t trials = 30;
  std::vector<std::string> candidates;
  ObjectArguments known;
  std::string place, hand, arm;
  std::vector<std::string> faults;
  bool campaign = false;
  std::string shard_text;
  Shard shard;
  LiveOption live;
};

/// One trial at a time for those who watch: the next that begins once the one before has ended.
class WatchedTrials {
 public:
  explicit WatchedTrials(std::unique_ptr<LiveView> view) : view_(std::move(view)) {}

  /// @return none while another is watched, or where nobody can
  std::shared_ptr<recording::Sink> begin(const geometry::KnownObject& object,
                                         const evaluation::TrialOptions& options,
                                         std::uint64_t seed) {
    if (!view_ || busy_.exchange(true)) return nullptr;
    const simulation::World world(object, options.world, seed);
    auto page = view_->begin(
        {std::string(version()), seed, object, world.hand_model(), to_toml(options), false},
        fmt::format("palpate eval, {} with seed {}", object.name, seed));
    return {page.release(), [this](recording::PageStream* stream) {
              stream->end("the trial has ended; the next one follows");
              delete stream;
              busy_ = false;
            }};
  }

 private:
  std::unique_ptr<LiveView> view_;
  std::atomic<bool> busy_ = false;
};

/// An object and what its name stands for, each.
std::vector<NamedObject> with_names(const std::vector<std::string>& names,
                                    const std::vector<geometry::KnownObject>& objects) {
  std::vector<NamedObject> all;
  for (std::size_t i = 0; i < names.size(); ++i) all.push_back({names[i], &objects[i]});
  return all;
}

std::vector<NamedObject> with_names(const CandidateObjects& candidates) {
  std::vector<NamedObject> all;
  for (std::size_t i = 0; i < candidates.names.size(); ++i) {
    all.push_back({candidates.names[i], &candidates.models[i].object()});
  }
  return all;
}

/// The pick that is the first trial, with the options that were given.
std::string repetition_of(const EvalArguments& arguments) {
  const std::string& first = arguments.objects.front();
  const bool is_known = arguments.candidates.empty();
  const auto option = [](const char* name, const std::string& value) {
    return value.empty() ? "" : fmt::format(" {} {}", name, quoted(value));
  };
  std::string command =
      "palpate pick" +
      option("--object",
             is_known ? first : fmt::format("{}", fmt::join(arguments.candidates, ","))) +
      option("--true-object", is_known ? "" : first) +
      option("--mass", arguments.known.mass ? fmt::format("{}", *arguments.known.mass) : "") +
      option("--at", arguments.known.at) +
      option("--units", arguments.known.units == "m" ? "" : arguments.known.units) +
      option("--place", arguments.place) + option("--hand", arguments.hand) +
      option("--arm", arguments.arm) + option("--config", arguments.common.config);
  for (const auto& setting : arguments.common.set) command += option("--set", setting);
  return fmt::format("{} --seed {}", command, arguments.common.seed);
}

EvalPlan plan_of(const EvalArguments& arguments, const evaluation::TrialOptions& options,
                 const std::vector<geometry::KnownObject>& objects,
                 const CandidateObjects& candidates) {
  EvalPlan plan;
  plan.objects = arguments.objects;
  for (const auto& object : objects) {
    plan.symmetry_orders.push_back(object.symmetries.size());
    plan.repairs.push_back(object.repairs);
  }
  plan.trials = arguments.trials;
  plan.seed = arguments.common.seed;
  plan.place = !options.place.target.empty();
  plan.configuration = trials_fingerprint(
      arguments.common, options, with_names(arguments.objects, objects), with_names(candidates));
  plan.commit = commit();
  plan.repetition = repetition_of(arguments);
  return plan;
}

/// Numbers of an object's trials that are of this share.
std::vector<std::size_t> own_trials(const EvalArguments& arguments, std::size_t object) {
  std::vector<std::size_t> numbers = evaluation::trial_numbers(arguments.trials);
  std::erase_if(numbers, [&](std::size_t number) {
    return !arguments.shard.has(object * arguments.trials + number);
  });
  return numbers;
}

/// Shows how many trials of the present object have ended.
class EvalProgress {
 public:
  EvalProgress(const std::vector<evaluation::EvaluatedObject>& objects,
               const EvalArguments& arguments)
      : objects_(objects), arguments_(arguments) {
    begin(0);
  }

  void count() {
    bar_->show(++done_);
    if (done_ == objects_[object_].numbers.size()) begin(object_ + 1);  // that is what runs now
  }

  /// The object has ended. Nothing is shown until the next one begins.
  void end() { bar_.reset(); }

  void begin(std::size_t object) {
    if (object >= objects_.size()) return;
    object_ = object;
    done_ = 0;
    bar_.emplace(arguments_.objects[object], objects_[object].numbers.size(),
                 arguments_.common.quiet);
    bar_->show(0);
  }

 private:
  const std::vector<evaluation::EvaluatedObject>& objects_;
  const EvalArguments& arguments_;
  std::optional<ProgressBar> bar_;
  std::size_t object_ = 0, done_ = 0;
};

/// What to do after an evaluation: put its shards together, or look at one of its trials.
std::string next_of(const EvalArguments& arguments) {
  if (!arguments.shard_text.empty()) {
    return fmt::format("palpate merge {} ... with the folders of the other shards",
                       quoted(arguments.common.out));
  }
  return repetition_text(repetition_of(arguments));
}

/// A target is that of an object which is known.
void check_candidates(const EvalArguments& arguments) {
  if (arguments.candidates.empty() || arguments.place.empty()) return;
  if (arguments.candidates.size() == 1 && arguments.objects.size() == 1 &&
      is_same_object(arguments.candidates.front(), arguments.objects.front())) {
    return;
  }
  throw BadInput(fmt::format("--candidates {} cannot be combined with --place {}",
                             fmt::join(arguments.candidates, ","), arguments.place));
}

int run_campaign(EvalArguments arguments) {
  if (!arguments.place.empty() || !arguments.shard_text.empty() || arguments.known.mass ||
      !arguments.known.at.empty() || arguments.known.units != "m" ||
      !arguments.candidates.empty() || arguments.live.option->count() > 0) {
    throw BadInput(
        "--faults cannot be combined with --place, --shard, --mass, --at, --units, --candidates "
        "or --live");
  }
  if (arguments.resume && (arguments.common.out.empty() || arguments.common.force)) {
    throw BadInput("--resume needs the --out of a campaign, and no --force");
  }
  std::erase(arguments.faults, "");  // what CLI11 makes of an option without values
  return eval_faults(resolve_trial(arguments.common, arguments.hand, arguments.arm),
                     arguments.common, arguments.objects, arguments.trials, arguments.faults,
                     arguments.resume);
}

/// @throws BadInput for options that do not go together
void check_options(const EvalArguments& arguments) {
  if (arguments.shard.count > 1 && arguments.common.out.empty()) {
    throw BadInput("--shard needs --out: `palpate merge` reads what it writes there");
  }
  if (arguments.resume && (arguments.common.out.empty() || arguments.common.force)) {
    throw BadInput("--resume needs the --out of an evaluation, and no --force");
  }
  const auto records = std::filesystem::path(arguments.common.out) / "trials.jsonl";
  if (arguments.resume && !std::filesystem::exists(records)) {
    throw BadInput(fmt::format("{}: there is no evaluation to go on with", records.string()));
  }
}

int eval(EvalArguments arguments) {
  if (arguments.campaign) return run_campaign(std::move(arguments));
  if (!arguments.shard_text.empty()) arguments.shard = parse_shard(arguments.shard_text);
  check_options(arguments);
  arguments.objects = geometry::expand_object_names(arguments.objects);
  require_distinct(arguments.objects);  // its trials would count twice
  arguments.candidates = geometry::expand_object_names(arguments.candidates);
  auto given = arguments.objects;
  given.insert(given.end(), arguments.candidates.begin(), arguments.candidates.end());
  require_mesh_file(given, arguments.known.units);
  check_candidates(arguments);
  auto options = resolve_trial(arguments.common, arguments.hand, arguments.arm);
  if (!arguments.place.empty()) options.place.target = place_text(arguments.place);
  apply_place(arguments.known, arguments.common.set, options.start);
  std::optional<Notice> notice(std::in_place, "preparing the objects", arguments.common.quiet);
  std::vector<geometry::KnownObject> objects(arguments.objects.size());
  parallel_for(objects.size(), arguments.common.threads, [&](std::size_t i) {
    objects[i] = load_object(arguments.objects[i], arguments.known);
  });
  const CandidateObjects known = load_objects(arguments.candidates, arguments.known);
  // What cannot be is named before anything moves, and before earlier results are lost.
  for (const auto& object : objects) {
    evaluation::check_trial(object, options, arguments.common.seed);
  }
  // What the simulator refuses is said before anything is printed or written.
  const simulation::World probe(objects.front(), options.world, arguments.common.seed);
  notice.reset();
  std::optional<EvalOutput> output;
  const EvalPlan plan = plan_of(arguments, options, objects, known);
  if (!arguments.common.out.empty()) {
    output.emplace(arguments.common, options, plan,
                   fmt::format("{}/{}", arguments.shard.number, arguments.shard.count));
  }
  WatchedTrials watched(arguments.live.open(arguments.common.quiet));
  EvalReport report(plan, arguments.common.json);
  std::vector<evaluation::EvaluatedObject> evaluated;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    evaluated.push_back({&objects[i], own_trials(arguments, i), known.find(arguments.objects[i])});
  }
  EvalProgress progress(evaluated, arguments);
  const std::uint64_t seed = arguments.common.seed;
  evaluation::EvaluationHooks hooks;
  hooks.finished = [&](evaluation::TrialId id) {
    return output ? output->find(arguments.objects[id.object], seed + id.number) : std::nullopt;
  };
  hooks.sink = [&](evaluation::TrialId id) {
    return watched.begin(objects[id.object], options, seed + id.number);
  };
  hooks.trial = [&](evaluation::TrialId id, const evaluation::Trial& trial) {
    progress.count();
    report.add(trial);
    if (output) output->add(arguments.objects[id.object], seed + id.number, trial);
  };
  hooks.object = [&](std::size_t object, const auto& summary) {
    progress.end();
    report.end_object(summary);
    progress.begin(object + 1);
  };
  evaluation::evaluate(evaluated, options, seed, arguments.common.threads, hooks,
                       known.candidates());
  const json summary = report.finish();
  if (output) output->finish(summary);
  if (output && !arguments.common.json) {
    fmt::print("wrote {}: eval.json, config.toml, trials.csv, trials.jsonl\n",
               arguments.common.out);
  }
  print_next(arguments.common, next_of(arguments));
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
      ->type_name("O[,O2..]")
      ->capture_default_str();
  command.add_option("--trials", arguments->trials, "picks per object")
      ->check(in_range(1, 1000000))
      ->capture_default_str();
  command.add_flag("--resume", arguments->resume,
                   "continue the evaluation in DIR, and refuse to start a new one");
  command
      .add_option("--shard", arguments->shard_text,
                  "run only shard I of N of the trials, for `palpate merge`")
      ->option_text("I/N");
  auto* const faults =
      command
          .add_option(
              "--faults", arguments->faults,
              "repeat the picks with each of these faults of the hand, injected at a random "
              "time, and with none; without a list, with all faults (docs/safety.md)")
          ->delimiter(',')
          ->type_name("KIND[,KIND2..]")
          ->expected(0, 100);
  add_place_option(command, arguments->place);
  command
      .add_option("--candidates", arguments->candidates,
                  "up to 10 objects among which the robot identifies the one present, or none "
                  "(default: the object is known)")
      ->delimiter(',')
      ->option_text("O,O2..");
  add_object_options(command, arguments->known);
  add_hand_option(command, arguments->hand);
  add_arm_option(command, arguments->arm);
  add_live_option(command, arguments->live);
  add_common_options(command, arguments->common);
  command.footer(
      "Trial i of every object has the seed SEED + i. With --out it writes eval.json,\n"
      "config.toml, manifest.json (program, commit, machine, configuration) and, as they finish,\n"
      "one row per trial in trials.csv and its details in trials.jsonl into DIR. The same command\n"
      "continues an interrupted run, with the same result bit for bit; one with other settings or\n"
      "meshes, or of a program built from another commit, is refused, unless --force starts over.\n"
      "With --faults it writes faults.json, and only --resume continues.\n\nExamples:\n"
      "  palpate eval --object mug,box --trials 30 --threads 2 --seed 9000\n"
      "  palpate eval --object generated:9000-9099 --trials 3 --seed 9000\n"
      "  palpate eval --object mug,duck --candidates mug,box,bottle --trials 10 --seed 9000\n"
      "  palpate eval --object duck --trials 10 --set attempts=1 --json\n"
      "  palpate eval --object box,mug --trials 5 --faults load_nan,finger_silent --json\n"
      "  palpate eval --object mug --trials 10 --threads 2 --live   # one trial at a time\n"
      "  palpate eval --place random --trials 20 --seed 9000\n"
      "  palpate eval --arm ur10 --object mug,box --trials 5 --seed 9000\n"
      "  palpate eval --trials 100 --seed 9000 --shard 3/16 --out part3\n"
      "  palpate eval --object box --place stable_pose --trials 10 --seed 9000");
  command.callback([arguments, faults, &chosen] {
    arguments->campaign = faults->count() > 0;
    chosen = [arguments] { return eval(*arguments); };
  });
}

}  // namespace palpate::app
