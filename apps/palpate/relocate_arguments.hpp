// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "palpate/tasks/relocate/policies/policy.hpp"
#include "palpate/tasks/relocate/relocation.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::app {

/// What rollout and compare let a user set.
struct RelocateOptions {
  relocate::TaskOptions task;
  relocate::EpisodeOptions episode;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("task", task);
    v.section("episode", episode);
  }
};

/// What rollout lets a user set.
struct RolloutOptions : RelocateOptions {
  relocate::RelocationOptions touch;

  template <class Visitor>
  void visit(Visitor&& v) {
    RelocateOptions::visit(v);
    v.section("touch", touch);
  }
};

/// The policy of a file, of a name in models/ ("relocate-best"), or the best that ships for "".
std::unique_ptr<relocate::Policy> find_policy(const std::string& name);

/// Adds --task, the version of the relocate task; there is one.
void add_task_option(CLI::App& command);

/// Whether it is the name or the file of a policy; no if it is a list of returns.
bool is_policy(const std::string& name);

/// "return", "success_10cm", ... as the program's interface names them.
nlohmann::json summary_json(const relocate::RolloutSummary& summary);

/// A CSV file of episodes: return, distance, steps_within_5cm, diverged.
std::string episodes_csv(const std::vector<relocate::Episode>& episodes);

/// The returns of a file that episodes_csv made. @throws BadInput, naming file and line
std::vector<double> read_returns(const std::string& path);

}  // namespace palpate::app
