// SPDX-License-Identifier: Apache-2.0
#include "relocate_arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "palpate/core/assets.hpp"
#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "usage.hpp"

namespace palpate::app {
namespace {

/// The best first.
constexpr std::array<std::string_view, 4> kShipped = {"relocate-best", "relocate-robust",
                                                      "relocate-memoryless", "relocate-box"};
constexpr const char* kHeader = "return,distance,steps_within_5cm,diverged";

constexpr double kMinReturn = 1e-30, kMaxReturn = 1e12;  // sizes of which squares can be computed

double number_before_comma(std::string_view line) {
  double value = 0;
  const char* const end = line.data() + line.size();
  const auto [rest, error] = std::from_chars(line.data(), end, value);
  if (error != std::errc() || rest == end || *rest != ',' || !std::isfinite(value)) {
    throw BadInput(fmt::format("'{}' is no row of {}", line, kHeader));
  }
  const double size = std::abs(value);
  if (size > kMaxReturn || (size > 0 && size < kMinReturn)) {
    throw BadInput(fmt::format("a return of {}: its size is neither 0 nor from {:g} to {:g}", value,
                               kMinReturn, kMaxReturn));
  }
  return value;
}

}  // namespace

namespace {

/// As relocate::load_policy, which says what is wrong but not that a policy is wanted.
std::unique_ptr<relocate::Policy> load_policy(const std::string& file) {
  try {
    return relocate::load_policy(file);
  } catch (const BadInput& error) {
    std::string what = error.what();
    if (what.starts_with(file + ": ")) what.erase(0, file.size() + 2);
    if (what.starts_with("not JSON"))
      throw BadInput(file + " is not a policy file: it is not JSON");
    throw BadInput(fmt::format("{} is not a policy file, or it is damaged: {}", file, what));
  }
}

}  // namespace

std::unique_ptr<relocate::Policy> find_policy(const std::string& name) {
  const std::string wanted = name.empty() ? std::string(kShipped.front()) : name;
  if (std::filesystem::exists(wanted)) return load_policy(wanted);
  if (std::ranges::find(kShipped, wanted) == kShipped.end()) {
    throw BadInput(fmt::format(
        "'{}' is neither a policy file nor a shipped policy ({}){}", wanted,
        fmt::join(kShipped, ", "),
        did_you_mean(wanted, std::vector<std::string>(kShipped.begin(), kShipped.end()))));
  }
  return relocate::load_policy(asset(fmt::format("models/{}.json", wanted)));
}

void add_task_option(CLI::App& command) {
  const std::string version(relocate::kRelocateVersion);
  command.add_option("--task")
      ->description("version of the task, of which this is the only one yet")
      ->check(CLI::IsMember({version}))
      ->default_str(version);
}

bool is_policy(const std::string& name) { return !name.ends_with(".csv"); }

namespace {

/// sd and ci95 are null of one episode.
nlohmann::json return_json(const relocate::RolloutSummary& s) {
  nlohmann::json spread = {{"mean", s.mean}, {"sd", nullptr}, {"ci95", nullptr}};
  if (s.ci95) {
    spread["sd"] = s.sd;
    spread["ci95"] = {s.ci95->low, s.ci95->high};
  }
  return spread;
}

}  // namespace

nlohmann::json summary_json(const relocate::RolloutSummary& s) {
  return {{"episodes", s.episodes},
          {"return", return_json(s)},
          {"success_10cm", s.success_10cm},
          {"success_5cm", s.success_5cm},
          {"success_2cm", s.success_2cm},
          {"success_steady_5cm", s.success_steady},
          {"median_distance", s.median_distance},
          {"diverged", s.diverged}};
}

std::string episodes_csv(const std::vector<relocate::Episode>& episodes) {
  std::string text = fmt::format("{}\n", kHeader);
  for (const auto& e : episodes) {
    text +=
        fmt::format("{},{},{},{}\n", e.total, e.distance, e.steps_within_5cm, e.diverged ? 1 : 0);
  }
  return text;
}

std::vector<double> read_returns(const std::string& path) {
  const std::string text = read_file(path);
  std::istringstream lines{std::string(without_byte_order_mark(text))};
  std::string line;
  std::getline(lines, line);
  if (trimmed(line) != kHeader) {
    throw BadInput(fmt::format("{}:1: '{}' is not the header {}", path, trimmed(line), kHeader));
  }
  std::vector<double> result;
  for (int number = 2; std::getline(lines, line); ++number) {
    try {
      result.push_back(number_before_comma(trimmed(line)));
    } catch (const BadInput& error) {
      throw BadInput(fmt::format("{}:{}: {}", path, number, error.what()));
    }
  }
  return result;
}

}  // namespace palpate::app
