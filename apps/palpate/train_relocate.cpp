// SPDX-License-Identifier: Apache-2.0
#include "train_relocate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string_view>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/tasks/relocate/minari_io.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "palpate/tasks/relocate/training/trainer.hpp"
#include "relocate_arguments.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using learning::Checkpoint;
using nlohmann::json;

struct TrainArguments {
  CommonOptions common;
  std::string method = "cem";
  std::string from, expert, demos;
  std::optional<int> iterations;              // none: kIterations
  std::optional<std::size_t> demonstrations;  // none: kDemonstrations
  std::size_t episodes = 30;
};

constexpr int kIterations = 40;
constexpr std::size_t kDemonstrations = 25;

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

/// Episodes that an expert shows.
relocate::Demonstrations show(const relocate::RelocateModel& model, const relocate::Policy& expert,
                              const relocate::EpisodeOptions& episode, std::uint64_t seed,
                              std::size_t count) {
  relocate::Demonstrations demos;
  const auto horizon = static_cast<Eigen::Index>(episode.horizon);
  demos.observations.resize(relocate::kRelocateObservations, 0);
  demos.actions.resize(relocate::kRelocateJoints, 0);
  for (std::size_t i = 0; i < count; ++i) {
    relocate::RelocateTask task(model);
    relocate::Path path;
    const auto agent = [&](int, const relocate::PolicyInput& input) { return expert.act(input); };
    const auto outcome = relocate::run_episode(task, relocate::episode_start(episode, seed, i),
                                               episode.horizon, agent, &path);
    if (outcome.diverged || !(outcome.distance < 0.05)) continue;  // only successes teach
    const Eigen::Index before = demos.actions.cols();
    demos.observations.conservativeResize(Eigen::NoChange, before + horizon);
    demos.actions.conservativeResize(Eigen::NoChange, before + horizon);
    demos.observations.rightCols(horizon) = path.observations.leftCols(horizon);
    demos.actions.rightCols(horizon) = path.actions.cwiseMax(-1).cwiseMin(1);
  }
  if (demos.actions.cols() == 0)
    throw BadInput("the expert does not succeed once: nothing to show");
  return demos;
}

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
};

relocate::MlpPolicy starting_network(const Training& training,
                                     const relocate::Demonstrations& demos,
                                     const TrainOptions& options, std::uint64_t seed) {
  if (!training.from) return relocate::clone_behavior(demos, options.bc, seed);
  const auto* network = dynamic_cast<const relocate::MlpPolicy*>(training.from.get());
  if (!network) throw BadInput("--from needs a policy of kind mlp for this method");
  return *network;
}

void make_gradient_trainer(const TrainArguments& arguments, const TrainOptions& options,
                           const relocate::TrainingContext& context, Training& training) {
  auto demos = demonstrations(arguments, options, context, training.expert.get());
  const auto network = starting_network(training, demos, options, context.seed);
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
      {"--iterations", arguments.iterations.has_value(), {"cem", "npg", "dapg"}}};
  for (const Use& use : uses) {
    const bool used =
        std::find(use.methods.begin(), use.methods.end(), arguments.method) != use.methods.end();
    if (use.given && !used) {
      throw BadInput(fmt::format("{} is of no use to {}", use.option, arguments.method));
    }
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
    training.trainer = relocate::make_cem_trainer(context, options.cem, from);
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

/// The learning curves so far: a row an iteration.
class Curves {
 public:
  explicit Curves(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void add(const relocate::Metrics& metrics) {
    const Eigen::Index row = values_.rows();
    values_.conservativeResize(row + 1, std::ssize(metrics));
    for (Eigen::Index k = 0; k < values_.cols(); ++k) {
      values_(row, k) = metrics[static_cast<std::size_t>(k)].second;
    }
    names_.clear();
    for (const auto& [name, value] : metrics) names_.push_back(name);
  }

  const Eigen::MatrixXd& values() const { return values_; }
  void restore(const Eigen::MatrixXd& values) { values_ = values; }

  void write() const {
    std::string csv = fmt::format("iteration,{}\n", fmt::join(names_, ","));
    for (Eigen::Index i = 0; i < values_.rows(); ++i) {
      csv += fmt::format("{}", i);
      for (const double value : values_.row(i)) csv += fmt::format(",{}", value);
      csv += "\n";
    }
    write_file_atomically(folder_ / "curves.csv", csv);
    for (std::size_t k = 0; k < names_.size(); ++k) write_figure(k);
  }

 private:
  void write_figure(std::size_t k) const {
    plotting::Plot plot;
    plot.title = names_[k];
    plot.x.label = "iteration";
    plot.y.label = names_[k];
    plotting::LineSeries line;
    for (Eigen::Index i = 0; i < values_.rows(); ++i) {
      line.x.push_back(static_cast<double>(i));
      line.y.push_back(values_(i, static_cast<Eigen::Index>(k)));
    }
    plot.series.emplace_back(line);
    write_file_atomically(folder_ / (names_[k] + ".svg"), plotting::to_svg(plot));
  }

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  Eigen::MatrixXd values_;
};

/// What identifies a training; one with others cannot go on in the same folder.
std::string settings_of(const TrainArguments& arguments, const TrainOptions& options) {
  return fmt::format("method {}, from '{}', expert '{}', demos '{}', demonstrations {}\n{}",
                     arguments.method, arguments.from, arguments.expert, arguments.demos,
                     arguments.demonstrations.value_or(kDemonstrations), to_toml(options));
}

bool resume(const std::filesystem::path& path, const TrainArguments& arguments,
            const std::string& settings, relocate::Trainer& trainer, Curves& curves) {
  if (!std::filesystem::exists(path)) return false;
  const Checkpoint checkpoint = learning::load_checkpoint(path);
  if (checkpoint.settings != settings || checkpoint.seed != arguments.common.seed) {
    throw BadInput(
        fmt::format("{} is of a training with other settings: use another --out", path.string()));
  }
  trainer.restore(checkpoint);
  curves.restore(checkpoint.array("curves"));
  return true;
}

void keep(const std::filesystem::path& folder, const TrainArguments& arguments,
          const std::string& settings, const relocate::Trainer& trainer, const Curves& curves) {
  Checkpoint checkpoint;
  checkpoint.method = arguments.method;
  checkpoint.seed = arguments.common.seed;
  checkpoint.iteration = trainer.iteration();
  checkpoint.settings = settings;
  checkpoint.arrays["curves"] = curves.values();
  trainer.save(checkpoint);
  learning::save_checkpoint(folder / "checkpoint", checkpoint);
}

/// The command that makes the training again, but for --threads, --out and the evaluation.
std::string command_of(const TrainArguments& arguments) {
  const auto& common = arguments.common;
  std::string command = fmt::format("palpate train relocate --method {}", arguments.method);
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) command += fmt::format(" {} {}", option, value);
  };
  add("--config", common.config);
  add("--from", arguments.from);
  add("--expert", arguments.expert);
  add("--demos", arguments.demos);
  if (arguments.demonstrations)
    add("--demonstrations", fmt::format("{}", *arguments.demonstrations));
  if (arguments.iterations) add("--iterations", fmt::format("{}", *arguments.iterations));
  add("--seed", fmt::format("{}", common.seed));
  for (const auto& assignment : common.set) add("--set", assignment);
  return command;
}

void write_policy(const std::filesystem::path& folder, const TrainArguments& arguments,
                  const relocate::Trainer& trainer) {
  auto record = trainer.policy();
  record.notes = {{"command", command_of(arguments)},
                  {"seed", fmt::format("{}", arguments.common.seed)},
                  {"iterations", fmt::format("{}", trainer.iteration())}};
  relocate::save_policy(folder / "policy.json", record);
}

void log_iteration(const CommonOptions& common, int iteration, const relocate::Metrics& metrics,
                   double seconds) {
  if (common.quiet) return;
  std::string text = fmt::format("iteration {:>4}  {:>6.0f} s", iteration, seconds);
  for (const auto& [name, value] : metrics) text += fmt::format("  {} {:.4g}", name, value);
  fmt::print(stderr, "{}\n", text);
}

relocate::RolloutSummary evaluate(const TrainArguments& arguments, const TrainOptions& options,
                                  const relocate::Policy& policy) {
  auto task = options.task;
  task.solver = "faithful";
  const auto& episode = arguments.method == "cem"      ? options.cem.search.episode
                        : arguments.method == "dagger" ? options.dagger.episode
                                                       : options.npg.episode;
  return relocate::summarize(relocate::rollout(relocate::make_model(task), policy, episode,
                                               arguments.common.seed + 500, arguments.episodes,
                                               arguments.common.threads));
}

int train(const TrainArguments& arguments) {
  const auto& common = arguments.common;
  if (common.out.empty()) throw BadInput("--out DIR is missing: where the training is to be kept");
  check_use(arguments);
  const auto options = resolve<TrainOptions>(common);
  // Without --force a training goes on, if its settings are the same.
  const auto output = claim_output(
      common, common.force ? std::vector<std::string>{"checkpoint", "policy.json", "report.json",
                                                      "curves.csv", "config.toml"}
                           : std::vector<std::string>{});
  const std::filesystem::path folder = common.out;
  const relocate::TrainingContext context{
      relocate::make_model(options.task), common.seed, common.threads,
      relocate::randomized_worlds(options.task, options.cem.randomization)};
  const Training training = make_training(arguments, options, context);
  const std::string settings = settings_of(arguments, options);
  Curves curves(folder);
  resume(folder / "checkpoint", arguments, settings, *training.trainer, curves);
  write_file_atomically(folder / "config.toml", config_header(common) + to_toml(options));

  const auto start = std::chrono::steady_clock::now();
  const int planned = planned_iterations(arguments, options);
  while (training.trainer->iteration() < planned) {
    const auto metrics = training.trainer->iterate();
    curves.add(metrics);
    write_policy(folder, arguments, *training.trainer);
    curves.write();
    // Last: what an interrupted iteration has not written, the next run writes.
    keep(folder, arguments, settings, *training.trainer, curves);
    log_iteration(common, training.trainer->iteration(), metrics,
                  std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  write_policy(folder, arguments, *training.trainer);
  const auto summary = evaluate(arguments, options, *relocate::load_policy(folder / "policy.json"));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  json report = summary_json(summary);
  report["iterations"] = training.trainer->iteration();
  report["seconds"] = seconds;
  report["steps_per_second"] = nullptr;
  write_file_atomically(folder / "report.json", report.dump(2) + "\n");
  if (common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    fmt::print(
        "return {:.0f} +- {:.0f}; {:.3f} within 5 cm, {:.3f} within 2 cm of {} episodes, "
        "faithful model\nwrote {}\n",
        summary.mean, summary.sd, summary.success_5cm, summary.success_2cm, summary.episodes,
        (folder / "policy.json").string());
    print_next(common, fmt::format("palpate rollout {}", (folder / "policy.json").string()));
  }
  return kDone;
}

}  // namespace

void add_train_relocate(CLI::App& train_command, Command& chosen) {
  auto arguments = std::make_shared<TrainArguments>();
  auto& command = *train_command.add_subcommand("relocate", "Train a policy for the relocate task");
  command.add_option("--method", arguments->method, "training method")
      ->check(CLI::IsMember({"cem", "dagger", "bc", "npg", "dapg"}))
      ->capture_default_str();
  command
      .add_option(
          "--iterations", arguments->iterations,
          fmt::format("iterations of cem, npg and dapg (default: {}); for dagger see dagger.rounds",
                      kIterations))
      ->check(in_range(1, 1000000));
  command.add_option("--from", arguments->from, "policy to start from (cem, npg, dapg)");
  command.add_option("--expert", arguments->expert,
                     "policy that demonstrates the task (dagger, bc, dapg; default: "
                     "the best shipped one)");
  command.add_option("--demos", arguments->demos,
                     "folder of demonstrations (bc, dapg), in place of an expert");
  command
      .add_option(
          "--demonstrations", arguments->demonstrations,
          fmt::format("episodes by the expert (bc, dapg; default: {}), of which the successful "
                      "ones are kept",
                      kDemonstrations))
      ->check(in_range(1, 100000));
  command.add_option("--episodes", arguments->episodes, "episodes of the final evaluation")
      ->check(in_range(2, 1000000))
      ->capture_default_str();
  add_task_option(command);
  add_common_options(command, arguments->common);
  command.footer(
      "DIR keeps a checkpoint of every iteration, the policy so far, and learning curves. The "
      "same\n"
      "command goes on where it was interrupted. The result is evaluated on the faithful model.\n\n"
      "Examples:\n"
      "  palpate train relocate --out out/cem --iterations 40 --threads 2\n"
      "  palpate train relocate --method dagger --expert out/cem/policy.json --out out/dagger\n"
      "  palpate train relocate --method dapg --seed 200 --set npg.trajectories=100 --out "
      "out/dapg");
  command.callback([arguments, &chosen] { chosen = [arguments] { return train(*arguments); }; });
}

}  // namespace palpate::app
