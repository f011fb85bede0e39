// SPDX-License-Identifier: Apache-2.0
#include "place_report.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "common.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "rate_text.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

json error_json(const localization::PoseError& error) {
  return {{"rotation_deg", kDegreesPerRadian * error.rotation},
          {"translation_mm", 1e3 * error.translation}};
}

json motion_json(const planning::Plan& motion) {
  json corners = json::array();
  for (const auto& corner : motion.corners) {
    const auto& mount = corner.mount;
    corners.push_back(
        {mount.xyz.x(), mount.xyz.y(), mount.xyz.z(), mount.ypr.x(), mount.ypr.y(), mount.ypr.z()});
  }
  return {{"status", planning::to_string(motion.status)},
          {"seconds", motion.seconds},
          {"duration", motion.duration()},
          {"checks", motion.checks},
          {"mount_corners", corners}};
}

json errors_json(const evaluation::ErrorSummary& errors) {
  return {{"rotation_deg", quantiles_json(errors.rotation_deg)},
          {"translation_mm", quantiles_json(errors.translation_mm)}};
}

json round_json(const skills::StrategyTaken::Round& round) {
  json considered = json::array();
  for (const auto& strategy : round.plan.considered) {
    considered.push_back({{"strategy", skills::to_string(strategy.strategy)},
                          {"possible", strategy.possible},
                          {"reason", strategy.reason}});
  }
  json place = nullptr;
  if (round.place) place = skills::to_string(*round.place);
  return {{"found", round.plan.found},
          {"strategy", skills::to_string(round.plan.strategy)},
          {"transfers", round.plan.transfers.size()},
          {"grasps", round.plan.grasps},
          {"seconds", round.plan.seconds},
          {"considered", considered},
          {"place", place}};
}

json turn_json(const skills::InHandReorientation& turn) {
  const auto& result = turn.result;
  return {{"asked_deg", kDegreesPerRadian * turn.asked.norm()},
          {"mount_turn_deg", kDegreesPerRadian * turn.mount_rotation},
          {"end", skills::to_string(result.end)},
          {"left", error_json(result.left)},
          {"known", turn.known},
          {"lost", turn.lost},
          {"steps", result.steps},
          {"rollouts", result.rollouts},
          {"robot_seconds", result.seconds},
          {"plan_seconds", result.plan_seconds}};
}

json strategy_json(const skills::StrategyTaken& strategy) {
  json rounds = json::array();
  for (const auto& round : strategy.rounds) rounds.push_back(round_json(round));
  json regrasp = nullptr;
  if (strategy.regrasp) regrasp = skills::to_string(*strategy.regrasp);
  json fingers = nullptr;
  if (strategy.reorientation) fingers = turn_json(*strategy.reorientation);
  return {{"chosen", skills::to_string(strategy.strategy)},
          {"reason", strategy.reason},
          {"fingers", fingers},
          {"regrasp", regrasp},
          {"rounds", rounds}};
}

/// One line: the strategy, why, and what the first plan found.
std::string strategy_text(const skills::StrategyTaken& strategy) {
  std::string text =
      fmt::format("strategy: {} ({})", skills::to_string(strategy.strategy), strategy.reason);
  if (!strategy.rounds.empty()) {
    for (const auto& way : strategy.rounds.front().plan.considered) {
      text += fmt::format("; {} {}: {}", skills::to_string(way.strategy),
                          way.possible ? "possible" : "impossible", way.reason);
    }
  }
  if (strategy.reorientation) {
    text += fmt::format("; fingers {}: {:.1f} of {:.1f} deg left, planned in {:.1f} s",
                        skills::to_string(strategy.reorientation->result.end),
                        kDegreesPerRadian * strategy.reorientation->result.left.rotation,
                        kDegreesPerRadian * strategy.reorientation->asked.norm(),
                        strategy.reorientation->result.plan_seconds);
  }
  if (strategy.regrasp) {
    text +=
        fmt::format("; {} round{}, {}", strategy.rounds.size(),
                    strategy.rounds.size() == 1 ? "" : "s", skills::to_string(*strategy.regrasp));
  }
  return text + "\n";
}

/// How those that were not placed ended.
std::string ends_text(std::map<std::string, std::size_t> ends) {
  ends.erase("placed");
  return counts_text(ends);
}

}  // namespace

void add_place_option(CLI::App& command, std::string& place) {
  command
      .add_option(
          "--place", place,
          "where to put the object down: 16 numbers of a pose of its centroid (or a file of them), "
          "x,y,yaw (m, rad; in the stable pose that it is found in), fixture (a slot), random, or "
          "stable_pose (another one than it starts in)")
      ->option_text("POSE|fixture");
}

std::string place_text(const std::string& argument) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(argument, error)) return argument;
  std::string text = read_file(argument);
  if (text.empty()) throw BadInput(fmt::format("{}: an empty file is no target", argument));
  return text;
}

std::string place_text(const evaluation::Trial& trial) {
  if (!trial.place) return "";
  const auto& metrics = trial.place_metrics;
  const std::string end =
      trial.place->status == skills::PlaceStatus::placed
          ? "placed"
          : fmt::format("not placed: {}", skills::to_string(trial.place->status));
  const auto& place = *trial.place;
  const std::string expected =
      place.certain || place.status != skills::PlaceStatus::placed
          ? ""
          : fmt::format(" (expected to lean by {:.0f} deg, as it stood; {:.2f} to stand upright)",
                        kDegreesPerRadian * place.lean, place.upright);
  return strategy_text(trial.strategy) +
         fmt::format("{}: {:.1f} deg, {:.1f} mm from the target{}\n", end,
                     kDegreesPerRadian * metrics.error.rotation, 1e3 * metrics.error.translation,
                     expected);
}

json place_json(const evaluation::Trial& trial) {
  if (!trial.place) return nullptr;
  const auto& place = *trial.place;
  const auto& metrics = trial.place_metrics;
  json placed = nullptr;
  if (place.T_world_placed) placed = to_json(*place.T_world_placed);
  return {{"status", skills::to_string(place.status)},
          {"strategy", strategy_json(trial.strategy)},
          {"certain", place.certain},
          {"certainty", place.held.certainty},
          {"lean_deg", kDegreesPerRadian * place.lean},
          {"upright", place.upright},
          {"other_stable_pose", place.other_stable_pose},
          {"T_world_target", to_json(place.T_world_target)},
          {"T_world_placed", placed},
          {"plan", motion_json(place.motion)},
          {"tight", metrics.tight},
          {"wrong", metrics.wrong},
          {"dropped", metrics.dropped},
          {"in_stable_pose", metrics.in_stable_pose},
          {"final_error", error_json(metrics.error)},
          {"estimate_error", error_json(metrics.estimate)},
          {"release_motion", error_json(metrics.release)}};
}

json place_summary_json(const evaluation::PlaceSummary& summary, std::size_t trials) {
  return {{"certain", rate(summary.certain, trials)},
          {"placed", rate(summary.placed, trials)},
          {"tight", rate(summary.tight, trials)},
          {"tight_of_certain", rate(summary.certain_tight, summary.certain)},
          {"wrong_of_certain", rate(summary.wrong, summary.certain)},
          {"dropped", rate(summary.dropped, trials)},
          {"in_stable_pose", rate(summary.in_stable_pose, trials)},
          {"status", summary.status},
          {"final_error", errors_json(summary.final_error)},
          {"estimate_error", errors_json(summary.estimate_error)},
          {"release_motion", errors_json(summary.release_motion)}};
}

std::string place_heading(std::size_t width) {
  return fmt::format("{:<{}} {:<18} {:<18} {:<18} {:<18} {:>11} {:>7} {:>7} {:>7} {:>7}   {}",
                     "object", width, "certain", "5 mm 3 deg*", "10 mm 5 deg", "wrong*",
                     "stable_pose", "dropped", "deg", "mm", "est. mm", "ends");
}

std::string place_row(const std::string& name, std::size_t width,
                      const evaluation::PlaceSummary& summary, std::size_t trials) {
  return fmt::format(
      "{:<{}} {:<18} {:<18} {:<18} {:<18} {:>11} {:>7} {:>7} {:>7} {:>7}   {}", name, width,
      rate_text(summary.certain, trials), rate_text(summary.certain_tight, summary.certain),
      rate_text(summary.placed, trials), rate_text(summary.wrong, summary.certain),
      summary.in_stable_pose, summary.dropped, median_text(summary.final_error.rotation_deg),
      median_text(summary.final_error.translation_mm),
      median_text(summary.estimate_error.translation_mm), ends_text(summary.status));
}

std::string phases_table(const std::map<std::string, evaluation::PhaseSummary>& phases) {
  std::string text =
      fmt::format("{:<13} {:>6} {:>6} {:>9} {:>9}\n", "phase", "runs", "ok", "robot s", "wall s");
  for (const auto& [name, phase] : phases) {
    text += fmt::format("{:<13} {:>6} {:>6.2f} {:>9.1f} {:>9.2f}\n", name, phase.runs,
                        rate(phase.ok, phase.runs).get<double>(), median(phase.robot_seconds),
                        median(phase.wall_seconds));
  }
  return text;
}

}  // namespace palpate::app
