// SPDX-License-Identifier: Apache-2.0
#include "train_rounds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using relocate::Episode;
using relocate::RolloutRequest;

/// Generation, candidate and first episode: what a line is about.
using Key = std::tuple<int, std::size_t, int>;

json to_json(const RolloutRequest& request, int generation) {
  return {{"generation", generation},
          {"candidate", request.candidate},
          {"first_episode", request.first},
          {"episodes", request.count}};
}

/// What is not finite is null in JSON: the distance of an episode that diverged.
json to_json(const Episode& episode) {
  return {{"return", episode.total},
          {"distance", episode.distance},
          {"steps_within_5cm", episode.steps_within_5cm},
          {"steps", episode.steps},
          {"diverged", episode.diverged}};
}

double number_or(const json& value, double otherwise) {
  return value.is_null() ? otherwise : value.get<double>();
}

Episode episode_of(const json& j) {
  return {number_or(j.at("return"), std::numeric_limits<double>::quiet_NaN()),
          number_or(j.at("distance"), std::numeric_limits<double>::infinity()),
          j.at("steps_within_5cm").get<int>(), j.at("steps").get<int>(),
          j.at("diverged").get<bool>()};
}

/// Calls take for each line. @throws BadInput, naming file and line
template <class Take>
void for_each_line(const fs::path& path, Take&& take) {
  std::istringstream text(read_file(path));
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    if (line.empty()) continue;
    try {
      take(json::parse(line));
    } catch (const json::exception& error) {
      throw BadInput(fmt::format("{}:{}: {}", path.string(), number, error.what()));
    }
  }
}

struct RolloutShare {
  std::size_t number = 0, count = 0;
};

RolloutShare parse_share(const std::string& text) {
  RolloutShare share;
  char end = 0;
  const int read = std::sscanf(text.c_str(), "%zu/%zu%c", &share.number, &share.count, &end);
  if (read != 2 || share.number < 1 || share.number > share.count) {
    throw BadInput(fmt::format("--score {}: it is I/N with 1 <= I <= N, as in 3/16", text));
  }
  return share;
}

bool is_scores(const std::string& name) {
  return name.starts_with("scores-") && name.ends_with(".jsonl");
}

}  // namespace

std::vector<std::string> score_names(const RoundFiles& files) {
  std::vector<std::string> names;
  std::error_code error;
  if (!fs::is_directory(files.folder, error)) return names;
  for (const auto& entry : fs::directory_iterator(files.folder)) {
    const std::string name = entry.path().filename().string();
    if (is_scores(name)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

void check_asked(const RoundFiles& files) {
  if (fs::exists(files.ask())) return;
  throw BadInput(fmt::format("{} does not exist: begin with --ask", files.ask().string()));
}

std::size_t write_requests(const RoundFiles& files, relocate::SearchTrainer& trainer) {
  std::string text;
  const auto requests = trainer.ask();
  for (const auto& request : requests) {
    json line = to_json(request, trainer.iteration());
    const Eigen::VectorXd x = trainer.parameters(request.candidate);
    line["parameters"] = std::vector<double>(x.begin(), x.end());
    text += json_text(line, -1);
  }
  write_file_atomically(files.ask(), text);
  return requests.size();
}

std::size_t run_share(const RoundFiles& files, const std::string& share_text,
                      const relocate::SearchTrainer& trainer) {
  const RolloutShare share = parse_share(share_text);
  std::vector<RolloutRequest> requests;
  std::vector<Eigen::VectorXd> parameters;
  std::size_t number = 0;
  for_each_line(files.ask(), [&](const json& line) {
    if (line.at("generation").get<int>() != trainer.iteration()) {
      throw BadInput(fmt::format("{} is of another generation than the checkpoint beside it",
                                 files.ask().string()));
    }
    if (number++ % share.count != share.number - 1) return;
    requests.push_back({line.at("candidate").get<std::size_t>(),
                        line.at("first_episode").get<int>(), line.at("episodes").get<int>()});
    const auto x = line.at("parameters").get<std::vector<double>>();
    parameters.emplace_back(Eigen::VectorXd::Map(x.data(), std::ssize(x)));
  });
  const auto results = trainer.run(requests, parameters);
  std::string text;
  for (std::size_t k = 0; k < requests.size(); ++k) {
    json line = to_json(requests[k], trainer.iteration());
    line["results"] = json::array();
    for (const Episode& episode : results[k]) line["results"].push_back(to_json(episode));
    text += json_text(line, -1);
  }
  write_file_atomically(
      files.folder / fmt::format("scores-{}-of-{}.jsonl", share.number, share.count), text);
  return requests.size();
}

std::optional<relocate::Metrics> take_results(const RoundFiles& files,
                                              relocate::SearchTrainer& trainer) {
  std::map<Key, std::vector<Episode>> rolled_out;
  for (const auto& name : score_names(files)) {
    for_each_line(files.folder / name, [&](const json& line) {
      auto& episodes =
          rolled_out[{line.at("generation").get<int>(), line.at("candidate").get<std::size_t>(),
                      line.at("first_episode").get<int>()}];
      episodes.clear();
      for (const json& one : line.at("results")) episodes.push_back(episode_of(one));
    });
  }
  relocate::SearchEpisodes results;
  std::size_t missing = 0, first_missing = 0;
  const auto requests = trainer.ask();
  for (const auto& request : requests) {
    const auto found = rolled_out.find({trainer.iteration(), request.candidate, request.first});
    if (found == rolled_out.end() && missing++ == 0) first_missing = request.candidate;
    if (found != rolled_out.end()) results.push_back(found->second);
  }
  if (missing > 0) {
    throw BadInput(fmt::format("{} of {} rollouts are missing, the first of candidate {}: --score",
                               missing, requests.size(), first_missing));
  }
  return trainer.tell(results);
}

void print_round(const CommonOptions& common, const RoundFiles& files, int generation,
                 std::size_t rollouts) {
  const json report = {
      {"generation", generation}, {"rollouts", rollouts}, {"path", files.ask().string()}};
  if (common.json) print_json(report);
  if (!common.json) fmt::print("generation {}: {} candidates\n", generation, rollouts);
}

void remove_rounds(const RoundFiles& files) {
  fs::remove(files.ask());
  for (const auto& name : score_names(files)) fs::remove(files.folder / name);
}

}  // namespace palpate::app
