// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>

#include "eval_arguments.hpp"
#include "eval_faults.hpp"
#include "eval_output.hpp"
#include "eval_report.hpp"
#include "fingerprint.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "manifest.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/version.hpp"
#include "palpate/evaluation/evaluation.hpp"
#include "place_report.hpp"
#include "progress_bar.hpp"
#include "terminal.hpp"
#include "trial_records.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

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
  const double size_range = arguments.known.size_range;
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
      option("--size-range", size_range > 0 ? fmt::format("{}", size_range) : "") +
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

int run_campaign(EvalArguments arguments) {
  if (!arguments.place.empty() || !arguments.shard_text.empty() || arguments.known.mass ||
      !arguments.known.at.empty() || arguments.known.units != "m" ||
      arguments.known.size_range > 0 || !arguments.candidates.empty() ||
      arguments.live.option->count() > 0) {
    throw BadInput(
        "--faults cannot be combined with --place, --shard, --mass, --at, --units, --size-range, "
        "--candidates or --live");
  }
  if (arguments.resume && (arguments.common.out.empty() || arguments.common.force)) {
    throw BadInput("--resume needs the --out of a campaign, and no --force");
  }
  std::erase(arguments.faults, "");  // what CLI11 makes of an option without values
  return eval_faults(resolve_trial(arguments.common, arguments.hand, arguments.arm),
                     arguments.common, arguments.objects, arguments.trials, arguments.faults,
                     arguments.resume);
}

evaluation::TrialOptions options_of(const EvalArguments& arguments) {
  auto options = resolve_trial(arguments.common, arguments.hand, arguments.arm);
  if (!arguments.place.empty()) options.place.target = place_text(arguments.place);
  apply_place(arguments.known, arguments.common.set, options.start);
  return options;
}

/// What stands there in the trials, and what the robot takes it for.
struct EvalObjects {
  std::vector<geometry::KnownObject> present;
  CandidateObjects candidates;
};

/// @throws BadInput for what cannot be, before anything is printed or written, moves or is lost
EvalObjects prepare_objects(const EvalArguments& arguments,
                            const evaluation::TrialOptions& options) {
  const Notice notice("preparing the objects", arguments.common.quiet);
  EvalObjects objects;
  objects.present.resize(arguments.objects.size());
  parallel_for(objects.present.size(), arguments.common.threads, [&](std::size_t i) {
    objects.present[i] = load_object(arguments.objects[i], arguments.known);
  });
  objects.candidates = load_objects(arguments.candidates, arguments.known);
  for (const auto& object : objects.present) {
    evaluation::check_trial(object, options, arguments.common.seed);
  }
  // The simulator, too, refuses some.
  const simulation::World probe(objects.present.front(), options.world, arguments.common.seed);
  return objects;
}

std::vector<evaluation::EvaluatedObject> evaluated_objects(const EvalArguments& arguments,
                                                           const EvalObjects& objects) {
  std::vector<evaluation::EvaluatedObject> evaluated;
  for (std::size_t i = 0; i < objects.present.size(); ++i) {
    evaluated.push_back({&objects.present[i], own_trials(arguments, i),
                         objects.candidates.find(arguments.objects[i])});
  }
  return evaluated;
}

std::unique_ptr<EvalOutput> open_output(const EvalArguments& arguments,
                                        const evaluation::TrialOptions& options,
                                        const EvalPlan& plan) {
  if (arguments.common.out.empty()) return nullptr;
  return std::make_unique<EvalOutput>(
      arguments.common, options, plan,
      fmt::format("{}/{}", arguments.shard.number, arguments.shard.count));
}

/// Writes, prints and shows what becomes of the trials.
class EvalFollower {
 public:
  /// All are kept by reference.
  EvalFollower(const EvalArguments& arguments, const evaluation::TrialOptions& options,
               const EvalObjects& objects,
               const std::vector<evaluation::EvaluatedObject>& evaluated)
      : arguments_(arguments),
        options_(options),
        objects_(objects),
        plan_(plan_of(arguments, options, objects.present, objects.candidates)),
        output_(open_output(arguments, options, plan_)),
        watched_(arguments.live.open(arguments.common.quiet)),
        report_(plan_, arguments.common.json),
        progress_(evaluated, arguments) {}

  evaluation::EvaluationHooks hooks() {
    evaluation::EvaluationHooks hooks;
    hooks.finished = [this](evaluation::TrialId id) {
      return output_ ? output_->find(name_of(id), seed_of(id)) : std::nullopt;
    };
    hooks.sink = [this](evaluation::TrialId id) {
      return watched_.begin(objects_.present[id.object], options_, seed_of(id));
    };
    hooks.trial = [this](evaluation::TrialId id, const evaluation::Trial& trial) {
      progress_.count();
      report_.add(trial);
      if (output_) output_->add(name_of(id), seed_of(id), trial);
    };
    hooks.object = [this](std::size_t object, const auto& summary) {
      progress_.end();
      report_.end_object(summary);
      progress_.begin(object + 1);
    };
    return hooks;
  }

  /// All trials have ended.
  void finish() {
    const json summary = report_.finish();
    if (output_) output_->finish(summary);
    if (output_ && !arguments_.common.json) {
      fmt::print("wrote {}: eval.json, config.toml, trials.csv, trials.jsonl\n",
                 arguments_.common.out);
    }
  }

 private:
  const std::string& name_of(evaluation::TrialId id) const { return arguments_.objects[id.object]; }
  std::uint64_t seed_of(evaluation::TrialId id) const { return arguments_.common.seed + id.number; }

  const EvalArguments& arguments_;
  const evaluation::TrialOptions& options_;
  const EvalObjects& objects_;
  EvalPlan plan_;
  std::unique_ptr<EvalOutput> output_;
  WatchedTrials watched_;
  EvalReport report_;
  EvalProgress progress_;
};

int eval(EvalArguments arguments) {
  if (arguments.campaign()) return run_campaign(std::move(arguments));
  complete(arguments);
  const auto options = options_of(arguments);
  const EvalObjects objects = prepare_objects(arguments, options);
  const auto evaluated = evaluated_objects(arguments, objects);
  EvalFollower follower(arguments, options, objects, evaluated);
  evaluation::evaluate(evaluated, options, arguments.common.seed, arguments.common.threads,
                       follower.hooks(), objects.candidates.candidates());
  follower.finish();
  print_next(arguments.common, next_of(arguments));
  return kDone;
}

}  // namespace

void add_eval(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<EvalArguments>();
  auto& command = *program.add_subcommand("eval", "Repeat the pick over seeds and report rates");
  add_eval_arguments(command, *arguments);
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
  command.callback([arguments, &chosen] { chosen = [arguments] { return eval(*arguments); }; });
}

}  // namespace palpate::app
