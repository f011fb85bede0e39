// SPDX-License-Identifier: Apache-2.0
#include "train_relocate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string_view>

#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/tasks/relocate/minari_io.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "palpate/tasks/relocate/training/trainer.hpp"
#include "relocate_arguments.hpp"
#include "terminal.hpp"
#include "train_demonstrations.hpp"
#include "train_folder.hpp"
#include "train_rounds.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

struct TrainOptions {
  relocate::TaskOptions task;
  relocate::CemTrainingOptions cem;
  relocate::DaggerOptions dagger;
  relocate::CloningOptions bc;
  relocate::NpgOptions npg;

  TrainOptions() { task.solver = "fast"; }

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("task", task);
    v.section("cem", cem);
    v.section("dagger", dagger);
    v.section("bc", bc);
    v.section("npg", npg);
  }
};

relocate::Demonstrations demonstrations(const TrainArguments& arguments,
                                        const TrainOptions& options,
                                        const relocate::TrainingContext& context,
                                        const relocate::Policy* expert) {
  if (arguments.method == "npg") return {};
  if (!arguments.demos.empty()) return relocate::frames_of(relocate::read_minari(arguments.demos));
  return show(context.model, *expert, options.npg.episode,
              RandomStream(context.seed, "demonstrations").bits() % 1000000,
              arguments.demonstrations.value_or(kDemonstrations));
}

/// A training with what it must keep alive.
struct Training {
  std::unique_ptr<relocate::Policy> expert, from;
  std::unique_ptr<relocate::Trainer> trainer;
  relocate::SearchTrainer* search = nullptr;  ///< the same, of cem
};

relocate::MlpPolicy starting_network(const Training& training,
                                     const relocate::Demonstrations& demos,
                                     const TrainOptions& options, std::uint64_t seed) {
  if (!training.from) return relocate::clone_behavior(demos, options.bc, seed);
  const auto* network = dynamic_cast<const relocate::MlpPolicy*>(training.from.get());
  if (!network) throw BadInput("--from needs a policy of kind mlp for this method");
  return *network;
}

/// The first iteration raises standard deviations below the least one.
void say_raised(const TrainArguments& arguments, const relocate::NpgOptions& options,
                const relocate::MlpPolicy& network) {
  const auto low = (network.log_std().array() < options.min_log_std).count();
  if (low == 0 || arguments.method == "bc" || arguments.common.quiet) return;
  fmt::print(stderr, "log_std of {} of {} actions is raised to npg.min_log_std = {}\n", low,
             network.log_std().size(), options.min_log_std);
}

void make_gradient_trainer(const TrainArguments& arguments, const TrainOptions& options,
                           const relocate::TrainingContext& context, Training& training) {
  const Notice notice("demonstrations, and cloning them", arguments.common.quiet);
  auto demos = demonstrations(arguments, options, context, training.expert.get());
  const auto network = starting_network(training, demos, options, context.seed);
  say_raised(arguments, options.npg, network);
  training.trainer = relocate::make_npg_trainer(context, options.npg, network, std::move(demos));
}

/// Refuses options that the method would not look at.
void check_use(const TrainArguments& arguments) {
  struct Use {
    const char* option;
    bool given;
    std::vector<std::string_view> methods;
  };
  const std::vector<Use> uses = {
      {"--from", !arguments.from.empty(), {"cem", "npg", "dapg"}},
      {"--expert", !arguments.expert.empty(), {"dagger", "bc", "dapg"}},
      {"--demos", !arguments.demos.empty(), {"bc", "dapg"}},
      {"--demonstrations", arguments.demonstrations.has_value(), {"bc", "dapg"}},
      {"--iterations", arguments.iterations.has_value(), {"cem", "npg", "dapg"}},
      {"--ask", arguments.ask, {"cem"}},
      {"--score", !arguments.score.empty(), {"cem"}},
      {"--tell", arguments.tell, {"cem"}}};
  for (const Use& use : uses) {
    const bool used =
        std::find(use.methods.begin(), use.methods.end(), arguments.method) != use.methods.end();
    if (use.given && !used) {
      throw BadInput(fmt::format("{} is of no use to {}", use.option, arguments.method));
    }
  }
  if (int{arguments.ask} + int{arguments.tell} + int{!arguments.score.empty()} > 1) {
    throw BadInput("--ask, --score and --tell come one after another");
  }
  if (arguments.common.force && (arguments.tell || !arguments.score.empty())) {
    throw BadInput("--force starts over: of these three options, only --ask takes it");
  }
  if (arguments.demos.empty()) return;
  if (!arguments.expert.empty()) throw BadInput("--expert is of no use with --demos");
  if (arguments.demonstrations) throw BadInput("--demonstrations is of no use with --demos");
}

Training make_training(const TrainArguments& arguments, const TrainOptions& options,
                       const relocate::TrainingContext& context) {
  Training training;
  if (!arguments.from.empty()) training.from = find_policy(arguments.from);
  const std::string& method = arguments.method;
  if (method != "cem" && method != "npg" && arguments.demos.empty()) {
    training.expert = find_policy(arguments.expert);
  }
  if (method == "cem") {
    const auto* from = dynamic_cast<const relocate::StructuredPolicy*>(training.from.get());
    if (training.from && !from) throw BadInput("--from needs a policy of kind structured for cem");
    auto search = relocate::make_cem_trainer(context, options.cem, from);
    training.search = search.get();
    training.trainer = std::move(search);
  } else if (method == "dagger") {
    training.trainer = relocate::make_dagger_trainer(context, options.dagger, *training.expert);
  } else {
    make_gradient_trainer(arguments, options, context, training);
  }
  return training;
}

int planned_iterations(const TrainArguments& arguments, const TrainOptions& options) {
  if (arguments.method == "bc") return 0;
  return arguments.method == "dagger" ? options.dagger.rounds
                                      : arguments.iterations.value_or(kIterations);
}

/// What identifies a training; one with others cannot go on in the same folder.
std::string settings_of(const TrainArguments& arguments, const TrainOptions& options) {
  return fmt::format("method {}, from '{}', expert '{}', demos '{}', demonstrations {}\n{}",
                     arguments.method, arguments.from, arguments.expert, arguments.demos,
                     arguments.demonstrations.value_or(kDemonstrations), to_toml(options));
}

/// The iteration that has ended, counted from 0 as in curves.csv.
void log_iteration(const CommonOptions& common, const relocate::Trainer& trainer,
                   const relocate::Metrics& metrics, double seconds) {
  if (common.quiet) return;
  std::string text = fmt::format("iteration {:>4}  {:>6.0f} s", trainer.iteration() - 1, seconds);
  for (const auto& [name, value] : metrics) text += fmt::format("  {} {:.4g}", name, value);
  fmt::print(stderr, "{}\n", text);
}

relocate::RolloutSummary evaluate(const TrainArguments& arguments, const TrainOptions& options,
                                  const relocate::Policy& policy) {
  auto task = options.task;
  task.solver = "faithful";
  const Notice notice("evaluating the policy", arguments.common.quiet);
  const auto& episode = arguments.method == "cem"      ? options.cem.search.episode
                        : arguments.method == "dagger" ? options.dagger.episode
                                                       : options.npg.episode;
  return relocate::summarize(relocate::rollout(relocate::make_model(task), policy, episode,
                                               arguments.common.seed + 500, arguments.episodes,
                                               arguments.common.threads));
}

/// The share of the rollouts that was asked for; the folder is another's.
int score_share(const TrainArguments& arguments, const Training& training, TrainingFolder& kept) {
  const RoundFiles files(kept.path());
  if (!kept.resume(*training.trainer))
    throw BadInput(fmt::format("{} has no checkpoint: begin with --ask", files.folder.string()));
  const auto rollouts = run_share(files, arguments.score, *training.search);
  print_round(arguments.common, files, training.trainer->iteration(), rollouts);
  return kDone;
}

/// Takes the scores and asks for the next. @return whether the search has ended
bool tell_and_ask(const TrainArguments& arguments, int planned, const Training& training,
                  TrainingFolder& kept) {
  const RoundFiles files(kept.path());
  if (arguments.tell) {
    if (const auto metrics = take_results(files, *training.search)) {
      kept.keep_iteration(*training.trainer, *metrics);
      log_iteration(arguments.common, *training.trainer, *metrics, 0);
    }
  }
  const bool ended = training.trainer->iteration() >= planned;
  if (!ended) training.search->ask();  // what is kept has its preparations
  kept.keep_checkpoint(*training.trainer);
  if (arguments.tell) remove_rounds(files);
  if (ended) return true;
  const auto rollouts = write_requests(files, *training.search);
  print_round(arguments.common, files, training.trainer->iteration(), rollouts);
  return false;
}

void print_result(const CommonOptions& common, const relocate::RolloutSummary& summary,
                  const std::string& policy) {
  fmt::print(
      "return {:.0f} +- {:.0f}; {:.3f} within 5 cm, {:.3f} within 2 cm of {} episodes, "
      "faithful model\nwrote {}\n",
      summary.mean, summary.sd, summary.success_5cm, summary.success_2cm, summary.episodes, policy);
  print_next(common, "palpate rollout " + quoted(policy));
}

int train(const TrainArguments& arguments) {
  const auto& common = arguments.common;
  if (common.out.empty()) throw BadInput("--out DIR is missing: where the training is to be kept");
  check_use(arguments);
  const auto options = resolve<TrainOptions>(common);
  if (arguments.tell || !arguments.score.empty()) check_asked(RoundFiles(common.out));
  const auto output = claim_training(arguments);
  const relocate::TrainingContext context{
      relocate::make_model(options.task), common.seed, common.threads,
      relocate::randomized_worlds(options.task, options.cem.randomization)};
  const Training training = make_training(arguments, options, context);
  TrainingFolder kept(arguments, settings_of(arguments, options));
  if (!arguments.score.empty()) return score_share(arguments, training, kept);
  if (!kept.resume(*training.trainer)) kept.keep_checkpoint(*training.trainer);
  const std::filesystem::path& folder = kept.path();
  write_file_atomically(folder / "config.toml", config_header(common) + to_toml(options));

  const auto start = std::chrono::steady_clock::now();
  const int planned = planned_iterations(arguments, options);
  if (arguments.by_rounds() && !tell_and_ask(arguments, planned, training, kept)) {
    return kDone;
  }
  while (training.trainer->iteration() < planned) {
    const auto metrics = training.trainer->iterate();
    kept.keep_iteration(*training.trainer, metrics);
    log_iteration(common, *training.trainer, metrics,
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  kept.write_policy(*training.trainer);
  const auto summary = evaluate(arguments, options, *relocate::load_policy(folder / "policy.json"));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  json report = summary_json(summary);
  report["iterations"] = training.trainer->iteration();
  report["seconds"] = seconds;
  write_file_atomically(folder / "report.json", json_text(report));
  if (common.json) {
    print_json(report);
  } else {
    print_result(common, summary, (folder / "policy.json").string());
  }
  return kDone;
}

}  // namespace

std::vector<OptionInfo> train_relocate_option_list() { return list_options(TrainOptions{}); }

void add_train_relocate(CLI::App& train_command, Command& chosen) {
  auto arguments = std::make_shared<TrainArguments>();
  auto& command = *train_command.add_subcommand("relocate", "Train a policy for the relocate task");
  command.add_option("--method", arguments->method, "training method")
      ->check(CLI::IsMember({"cem", "dagger", "bc", "npg", "dapg"}))
      ->capture_default_str();
  command
      .add_option(
          "--iterations", arguments->iterations,
          fmt::format("iterations of cem, npg, dapg (default: {}); dagger has dagger.rounds",
                      kIterations))
      ->check(in_range(1, 1000000));
  command.add_option("--from", arguments->from, "policy to start from (cem, npg, dapg)")
      ->option_text("POLICY");
  command
      .add_option("--expert", arguments->expert,
                  "policy that demonstrates the task (dagger, bc, dapg; default: relocate-best)")
      ->option_text("POLICY");
  command
      .add_option("--demos", arguments->demos,
                  "folder of demonstrations (bc, dapg), instead of an expert")
      ->option_text("DIR");
  command
      .add_option("--demonstrations", arguments->demonstrations,
                  fmt::format("episodes by the expert (bc, dapg; default: {}); successes are kept",
                              kDemonstrations))
      ->check(in_range(1, 100000));
  command.add_flag("--ask", arguments->ask,
                   "for many machines (cem): write DIR/ask.jsonl, the rollouts of a generation");
  command
      .add_option("--score", arguments->score,
                  "run share I of N of the rollouts in ask.jsonl, to DIR/scores-I-of-N.jsonl")
      ->option_text("I/N");
  command.add_flag("--tell", arguments->tell,
                   "read the results, write the next ask.jsonl; at last, evaluate the policy");
  command.add_option("--episodes", arguments->episodes, "episodes of the final evaluation")
      ->check(in_range(2, 1000000))
      ->capture_default_str();
  add_task_option(command);
  add_common_options(command, arguments->common);
  command.footer(
      "DIR has the last iteration's checkpoint, the current policy, and learning curves. The same\n"
      "command continues an interrupted run. The result is evaluated on the faithful model.\n"
      "Machines may share the rollouts of cem: --ask once, then --score I/N on each and --tell,\n"
      "until no ask.jsonl is left (examples/cluster/cem.sh); the result is that of one machine.\n\n"
      "Examples:\n"
      "  palpate train relocate --out out/cem --iterations 40 --threads 2\n"
      "  palpate train relocate --method dagger --expert out/cem/policy.json --out out/dagger\n"
      "  palpate train relocate --method dapg --seed 200 --set npg.trajectories=100 --out "
      "out/dapg");
  command.callback([arguments, &chosen] { chosen = [arguments] { return train(*arguments); }; });
}

}  // namespace palpate::app
