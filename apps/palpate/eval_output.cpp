// SPDX-License-Identifier: Apache-2.0
#include "eval_output.hpp"

#include <fmt/format.h>

#include "manifest.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::app {
namespace {

/// Without --force an evaluation goes on, so that nothing is in its way.
std::vector<std::string> removed_by_force(bool force) {
  if (!force) return {};
  return {"trials.jsonl", "trials.csv", "eval.json", "config.toml", "manifest.json"};
}

}  // namespace

EvalOutput::EvalOutput(const CommonOptions& common, const evaluation::TrialOptions& options,
                       const EvalPlan& plan, const std::string& shard)
    : folder_(common.out, removed_by_force(common.force), common.force),
      records_(begin(), plan),
      table_(folder_.path() / "trials.csv", plan.place) {
  write_file_atomically(folder_.path() / "config.toml", config_header(common) + to_toml(options));
  std::filesystem::remove(folder_.path() / "eval.json");  // of fewer trials
  nlohmann::json made = manifest();
  made.update({{"configuration", plan.configuration},
               {"seed", plan.seed},
               {"objects", plan.objects},
               {"trials", plan.trials},
               {"shard", shard},
               {"threads", common.threads}});
  write_file_atomically(folder_.path() / "manifest.json", json_text(made));
}

std::filesystem::path EvalOutput::begin() const {
  const auto path = folder_.path() / "trials.jsonl";
  if (std::filesystem::exists(path)) return path;
  for (const std::string& name : removed_by_force(true)) {
    if (!std::filesystem::exists(folder_.path() / name)) continue;
    throw BadInput(
        fmt::format("{} is of another run: --force overwrites it, another --out keeps it",
                    (folder_.path() / name).string()));
  }
  return path;
}

void EvalOutput::add(const std::string& object, std::uint64_t seed,
                     const evaluation::Trial& trial) {
  const bool known = find(object, seed).has_value();
  records_.add(object, seed, trial);
  table_.add(object, seed, trial);
  if (!known) table_.write();
}

void EvalOutput::finish(const nlohmann::json& summary) {
  table_.write();
  write_file_atomically(folder_.path() / "eval.json", json_text(summary));
}

}  // namespace palpate::app
