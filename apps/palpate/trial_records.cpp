// SPDX-License-Identifier: Apache-2.0
#include "trial_records.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "palpate/core/durable_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/evaluation/trial_record.hpp"
#include "palpate/recording/json_text.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "palpate-trials 1";

std::string header_line(const std::string& configuration) {
  return json{{"format", kFormat}, {"configuration", configuration}}.dump() + "\n";
}

}  // namespace

TrialRecords::TrialRecords(std::filesystem::path path, std::string configuration)
    : path_(std::move(path)), configuration_(std::move(configuration)) {
  std::error_code error;
  std::string text = std::filesystem::exists(path_, error) ? read_file(path_) : "";
  const std::size_t whole = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
  if (whole == 0) {
    write_file_atomically(path_, header_line(configuration_));
    return;
  }
  if (whole < text.size()) {
    DurableFile file(path_, DurableFile::Mode::modify);
    file.truncate(whole);
    file.sync();
    file.close();
    text.resize(whole);
  }
  try {
    read(text);
  } catch (const json::exception& problem) {
    throw BadInput(fmt::format("{}: damaged: {}", path_.string(), problem.what()));
  }
}

void TrialRecords::read(const std::string& text) {
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at);
    const json value = recording::parse_json(std::string_view(text).substr(at, end - at));
    at = end + 1;
    if (line > 0) {
      trials_[{value.at("object").get<std::string>(), value.at("seed").get<std::uint64_t>()}] =
          evaluation::trial_from_json(value.at("trial"));
    } else if (value.value("format", "") != kFormat ||
               value.value("configuration", "") != configuration_) {
      throw BadInput(fmt::format(
          "{} is of an evaluation with other settings: use another --out, or --force to lose it",
          path_.string()));
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
  append_durably(path_, line.dump(-1, ' ', false, json::error_handler_t::replace) + "\n");
}

}  // namespace palpate::app
