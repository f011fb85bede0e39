// SPDX-License-Identifier: Apache-2.0
#include "trial_records.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

#include "common.hpp"
#include "earlier_results.hpp"
#include "palpate/core/durable_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/evaluation/trial_record.hpp"
#include "palpate/recording/json_text.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "palpate-trials 4";

std::string header_line(const EvalPlan& plan) {
  return json_text({{"format", kFormat},
                    {"objects", plan.objects},
                    {"symmetry_orders", plan.symmetry_orders},
                    {"trials", plan.trials},
                    {"seed", plan.seed},
                    {"place", plan.place},
                    {"configuration", plan.configuration},
                    {"commit", plan.commit},
                    {"repairs", plan.repairs},
                    {"repetition", plan.repetition}},
                   -1);
}

EvalPlan plan_of(const json& header) {
  EvalPlan plan;
  header.at("objects").get_to(plan.objects);
  header.at("symmetry_orders").get_to(plan.symmetry_orders);
  header.at("trials").get_to(plan.trials);
  header.at("seed").get_to(plan.seed);
  header.at("place").get_to(plan.place);
  header.at("configuration").get_to(plan.configuration);
  // Earlier checkouts did not write these.
  plan.commit = header.value("commit", plan.commit);
  plan.repairs = header.value("repairs", plan.repairs);
  plan.repetition = header.value("repetition", plan.repetition);
  plan.repairs.resize(plan.objects.size());
  constexpr std::size_t kMostTrials = 1000000;  // that eval makes of each object
  if (plan.trials > kMostTrials || plan.symmetry_orders.size() != plan.objects.size()) {
    throw BadInput(fmt::format("a plan of {} trials of {} objects, of which {} have a symmetry",
                               plan.trials, plan.objects.size(), plan.symmetry_orders.size()));
  }
  return plan;
}

void erase_wall_time(json& value) {
  if (value.is_object()) value.erase("wall_seconds");
  if (!value.is_structured()) return;
  for (json& part : value) erase_wall_time(part);
}

/// A trial but for the wall time that it took. As text, for nan equals nan there.
std::string result_text(const evaluation::Trial& trial) {
  json result = evaluation::trial_to_json(trial);
  erase_wall_time(result);
  return json_text(result);
}

std::string commit_text(const EvalPlan& plan) {
  return plan.commit.empty() ? "an unknown commit" : plan.commit;
}

}  // namespace

bool EvalPlan::has(const std::string& object, std::uint64_t trial_seed) const {
  return std::ranges::find(objects, object) != objects.end() && trial_seed >= seed &&
         trial_seed - seed < trials;
}

void expect_same_plan(const std::string& name, const EvalPlan& plan, const std::string& other_name,
                      const EvalPlan& other) {
  const auto settings = [](const EvalPlan& p) {
    return std::tie(p.objects, p.symmetry_orders, p.trials, p.seed, p.place, p.configuration);
  };
  if (settings(plan) != settings(other)) {
    throw BadInput(
        fmt::format("{} and {} are of evaluations with other settings", name, other_name));
  }
  if (plan.commit == other.commit) return;
  throw BadInput(fmt::format("{} is of a program built from {}, {} of one from {}", name,
                             commit_text(plan), other_name, commit_text(other)));
}

TrialRecords TrialRecords::of(const std::filesystem::path& path) {
  TrialRecords records;
  records.path_ = path;
  const std::string text = read_file(path);
  read_earlier(path, [&] { records.read(text.substr(0, text.rfind('\n') + 1)); });
  if (records.plan_.objects.empty()) {
    throw BadInput(fmt::format("{} holds no trials of `palpate eval`", path.string()));
  }
  return records;
}

void TrialRecords::add_all(const TrialRecords& other) {
  expect_same_plan(path_.string(), plan_, other.path_.string(), other.plan_);
  for (const auto& [key, trial] : other.trials_) {
    const auto [known, added] = trials_.try_emplace(key, trial);
    if (added || result_text(known->second) == result_text(trial)) continue;
    throw BadInput(fmt::format(
        "{}: {} with seed {} went otherwise than in another part: they are of different programs",
        other.path_.string(), key.first, key.second));
  }
}

TrialRecords::TrialRecords(std::filesystem::path path, const EvalPlan& plan)
    : path_(std::move(path)), plan_(plan) {
  std::error_code error;
  std::string text = std::filesystem::exists(path_, error) ? read_file(path_) : "";
  const std::size_t whole = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
  if (whole == 0) {
    write_file_atomically(path_, header_line(plan_));
    return;
  }
  if (whole < text.size()) {
    DurableFile file(path_, DurableFile::Mode::modify);
    file.truncate(whole);
    file.sync();
    file.close();
    text.resize(whole);
  }
  read_earlier(path_, [&] { read(text); });
  try {
    expect_same_plan(path_.string(), plan_, "the command", plan);
  } catch (const BadInput& problem) {
    throw BadInput(fmt::format("{}: use another --out, or --force to lose it", problem.what()));
  }
}

void TrialRecords::read(const std::string& text) {
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at);
    const json value = recording::parse_json(std::string_view(text).substr(at, end - at));
    at = end + 1;
    if (line > 0) {
      const auto object = value.at("object").get<std::string>();
      const auto seed = value.at("seed").get<std::uint64_t>();
      if (!plan_.has(object, seed)) {
        throw BadInput(fmt::format("line {}: {} with seed {} is no trial of this evaluation",
                                   line + 1, object, seed));
      }
      trials_[{object, seed}] = evaluation::trial_from_json(value.at("trial"));
    } else if (value.value("format", "") != kFormat) {
      throw BadInput(fmt::format(
          "{} is of another version's evaluation: use another --out, or --force to lose it",
          path_.string()));
    } else {
      plan_ = plan_of(value);
    }
  }
}

std::optional<evaluation::Trial> TrialRecords::find(const std::string& object,
                                                    std::uint64_t seed) const {
  const auto found = trials_.find({object, seed});
  if (found == trials_.end()) return std::nullopt;
  return found->second;
}

void TrialRecords::add(const std::string& object, std::uint64_t seed,
                       const evaluation::Trial& trial) {
  if (trials_.contains({object, seed})) return;
  const json line = {
      {"object", object}, {"seed", seed}, {"trial", evaluation::trial_to_json(trial)}};
  append_durably(path_, json_text(line, -1));
}

}  // namespace palpate::app
