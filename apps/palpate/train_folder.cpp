// SPDX-License-Identifier: Apache-2.0
#include "train_folder.hpp"

#include <fmt/format.h>

#include <utility>

#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/learning/training/checkpoint.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "train_rounds.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;
using learning::Checkpoint;

constexpr const char* kCheckpoint = "checkpoint";
constexpr const char* kPolicy = "policy.json";

/// Names of the relocate::Metrics of a method.
std::vector<std::string> figures(const std::string& method) {
  if (method == "cem") return {"best", "elite", "observer_r2"};
  if (method == "dagger") return {"student_return", "action_error"};
  return {"evaluation",     "evaluation_5cm", "return",         "success_5cm",
          "surrogate_gain", "divergence",     "value_explained"};
}

std::vector<std::string> result_names(const TrainArguments& arguments) {
  const RoundFiles rounds(arguments.common.out);
  std::vector<std::string> names = score_names(rounds);
  names.push_back(rounds.ask().filename().string());
  for (const char* name : {kCheckpoint, kPolicy, "report.json", "curves.csv", "config.toml"}) {
    names.emplace_back(name);
  }
  for (const auto& figure : figures(arguments.method)) names.push_back(figure + ".svg");
  return names;
}

void keep_start(const TrainArguments& arguments) {
  const fs::path policy = fs::path(arguments.common.out) / kPolicy;
  for (const auto& start : {arguments.from, arguments.expert}) {
    std::error_code error;
    if (start.empty() || !fs::equivalent(start, policy, error)) continue;
    throw BadInput(
        fmt::format("--force would remove {}, from which the training is to start: use "
                    "another --out",
                    start));
  }
}

/// The command that makes the training again, but for --threads, --out and the evaluation.
std::string command_of(const TrainArguments& arguments, int iterations) {
  const auto& common = arguments.common;
  std::string command = fmt::format("palpate train relocate --method {}", arguments.method);
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) command += fmt::format(" {} {}", option, quoted(value));
  };
  add("--config", common.config);
  add("--from", arguments.from);
  add("--expert", arguments.expert);
  add("--demos", arguments.demos);
  if (arguments.demonstrations)
    add("--demonstrations", fmt::format("{}", *arguments.demonstrations));
  if (arguments.counts_iterations()) add("--iterations", fmt::format("{}", iterations));
  add("--seed", fmt::format("{}", common.seed));
  for (const auto& assignment : common.set) add("--set", assignment);
  return command;
}

}  // namespace

std::unique_ptr<OutputFolder> claim_training(const TrainArguments& arguments) {
  const CommonOptions& common = arguments.common;
  if (!arguments.score.empty()) return nullptr;
  if (common.force) keep_start(arguments);
  const bool goes_on = !common.force && fs::exists(fs::path(common.out) / kCheckpoint);
  return claim_output(common, goes_on ? std::vector<std::string>{} : result_names(arguments));
}

TrainingFolder::TrainingFolder(const TrainArguments& arguments, std::string settings)
    : arguments_(arguments),
      settings_(std::move(settings)),
      path_(arguments.common.out),
      curves_(path_) {}

bool TrainingFolder::resume(relocate::Trainer& trainer) {
  const fs::path file = path_ / kCheckpoint;
  if (!fs::exists(file)) return false;
  const Checkpoint checkpoint = learning::load_checkpoint(file);
  if (checkpoint.settings != settings_ || checkpoint.seed != arguments_.common.seed) {
    throw BadInput(
        fmt::format("{} is of a training with other settings: use another --out", file.string()));
  }
  trainer.restore(checkpoint);
  curves_.restore(checkpoint.array("curves"));
  return true;
}

void TrainingFolder::keep_checkpoint(const relocate::Trainer& trainer) const {
  Checkpoint checkpoint;
  checkpoint.method = arguments_.method;
  checkpoint.seed = arguments_.common.seed;
  checkpoint.iteration = trainer.iteration();
  checkpoint.settings = settings_;
  checkpoint.arrays["curves"] = curves_.values();
  trainer.save(checkpoint);
  learning::save_checkpoint(path_ / kCheckpoint, checkpoint);
}

void TrainingFolder::write_policy(const relocate::Trainer& trainer) const {
  auto record = trainer.policy();
  record.notes = {{"command", command_of(arguments_, trainer.iteration())},
                  {"seed", fmt::format("{}", arguments_.common.seed)},
                  {"iterations", fmt::format("{}", trainer.iteration())}};
  relocate::save_policy(path_ / kPolicy, record);
}

void TrainingFolder::keep_iteration(const relocate::Trainer& trainer,
                                    const relocate::Metrics& metrics) {
  curves_.add(metrics);
  write_policy(trainer);
  curves_.write();
  keep_checkpoint(trainer);
}

}  // namespace palpate::app
