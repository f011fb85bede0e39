// SPDX-License-Identifier: Apache-2.0
#include "pick_report.hpp"

#include <fmt/format.h>

#include <string_view>

#include "common.hpp"
#include "palpate/core/angle.hpp"
#include "place_report.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

using nlohmann::json;

json free_axis_json(const std::optional<localization::FreeAxis>& axis) {
  if (!axis) return nullptr;
  return {{"point", {axis->point.x(), axis->point.y(), axis->point.z()}},
          {"direction", {axis->direction.x(), axis->direction.y(), axis->direction.z()}},
          {"extent", axis->extent}};
}

json modes_json(const localization::Posterior& posterior) {
  json modes = json::array();
  for (const auto& mode : posterior.modes) {
    modes.push_back({{"T_world_object", to_json(mode.T_frame_object)},
                     {"weight", mode.weight},
                     {"free_axis", free_axis_json(mode.free_axis)}});
  }
  return modes;
}

/// An orientation of another object has no error.
json error_json(const evaluation::TrialMetrics& metrics, double error) {
  return metrics.object_ok ? json(error) : json();
}

json objects_json(const localization::ObjectProbabilities& objects,
                  const std::vector<std::string>& names) {
  json all = json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    all.push_back({{"name", names[i]}, {"probability", objects.candidates[i]}});
  }
  return all;
}

json estimate_json(const evaluation::Trial& trial, const std::vector<std::string>& names) {
  const auto& posterior = trial.result.estimate.posterior;
  const auto& metrics = trial.metrics;
  if (posterior.modes.empty()) return nullptr;
  return {{"status", localization::to_string(posterior.status)},
          {"object", names[trial.result.objects.best]},
          {"objects", objects_json(trial.result.objects, names)},
          {"other_object", trial.result.objects.other},
          {"size", trial.result.objects.size},
          {"object_ok", metrics.object_ok},
          {"T_world_object", to_json(posterior.modes[0].T_frame_object)},
          {"weight", posterior.modes[0].weight},
          {"probability", localization::pose_probability(posterior.modes[0])},
          {"rotation_error_deg", error_json(metrics, kDegreesPerRadian * metrics.error.rotation)},
          {"translation_error_mm", 1e3 * metrics.error.translation},
          {"rotation_error_without_symmetry_deg",
           error_json(metrics, kDegreesPerRadian * metrics.error_no_symmetry.rotation)},
          {"coverage", metrics.covered},
          {"modes", modes_json(posterior)},
          {"seconds", posterior.seconds}};
}

json phase_json(const skills::PhaseReport& report) {
  return {{"name", report.name},
          {"status", skills::to_string(report.status)},
          {"outcome", report.outcome},
          {"robot_seconds", report.robot_seconds},
          {"wall_seconds", report.wall_seconds},
          {"contacts", report.contacts},
          {"peak_force", report.peak_force}};
}

json fault_json(const skills::FaultReport& report, bool stopped) {
  return {{"name", to_string(report.fault)},
          {"detail", report.detail},
          {"time", report.time},
          {"stopped", stopped}};
}

/// Those with which the pick went on, and the one that stopped it, if any did.
json faults_json(const skills::PickResult& result) {
  json faults = json::array();
  for (const auto& report : result.survived) faults.push_back(fault_json(report, false));
  if (result.fault) faults.push_back(fault_json(result.fault, true));
  return faults;
}

std::string pose_text(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d p = 1e3 * T.translation();
  const Eigen::Quaterniond q(T.linear());
  return fmt::format(
      "at {:.1f}, {:.1f}, {:.1f} mm, quaternion (w x y z) {:.3f} {:.3f} {:.3f} {:.3f}", p.x(),
      p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
}

std::string counted(std::size_t count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string weights_of_others(const std::vector<localization::Mode>& modes) {
  std::string text;
  for (std::size_t i = 1; i < modes.size(); ++i) {
    text += fmt::format("{}{:.2f}", i == 1 ? "" : ", ", modes[i].weight);
  }
  return text;
}

}  // namespace

std::string phase_heading() {
  return fmt::format("{:<12} {:>9} {:>9} {:>9} {:>8}  {}", "phase", "robot", "wall", "contacts",
                     "force", "outcome");
}

std::string phase_row(const skills::PhaseReport& report) {
  const std::string outcome =
      report.status == skills::PhaseStatus::ok
          ? report.outcome
          : fmt::format("{}: {}", colored_status(skills::to_string(report.status)), report.outcome);
  return fmt::format("{:<12} {:>7.1f} s {:>7.2f} s {:>9} {:>6.1f} N  {}", report.name,
                     report.robot_seconds, report.wall_seconds, report.contacts, report.peak_force,
                     outcome);
}

std::string estimate_text(const evaluation::Trial& trial) {
  const auto& posterior = trial.result.estimate.posterior;
  if (posterior.modes.empty()) return "no pose explains the contacts";
  const auto& best = posterior.modes[0];
  std::string text =
      fmt::format("pose: {} ({:.2f}){}: {:.1f} deg, {:.1f} mm from the truth; searched {:.2f} s",
                  colored_status(localization::to_string(posterior.status)),
                  localization::pose_probability(best),
                  best.free_axis ? fmt::format(", free by +-{:.0f} deg about an axis",
                                               kDegreesPerRadian * best.free_axis->extent)
                                 : "",
                  kDegreesPerRadian * trial.metrics.error.rotation,
                  1e3 * trial.metrics.error.translation, posterior.seconds);
  text += fmt::format("\nobject in the world {}", pose_text(best.T_frame_object));
  if (posterior.modes.size() > 1) {
    text += fmt::format(
        "\n{} ({}); the truth is {} the modes", counted(posterior.modes.size() - 1, "other mode"),
        weights_of_others(posterior.modes), trial.metrics.covered ? "among" : "NOT among");
  }
  return text;
}

/// Which of several objects it is, the most probable first.
std::string objects_text(const evaluation::Trial& trial, const std::vector<std::string>& names) {
  const localization::ObjectProbabilities& objects = trial.result.objects;
  if (names.size() < 2 || !trial.metrics.has_pose) return "";
  std::string text = fmt::format("object: {} ({:.2f}), which is {}", names[objects.best],
                                 objects.probability, trial.metrics.object_ok ? "right" : "WRONG");
  if (objects.size != 1) text += fmt::format("; {:.3f} times the size of its mesh", objects.size);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i != objects.best) text += fmt::format("; {} {:.2f}", names[i], objects.candidates[i]);
  }
  return fmt::format("{}; another one {:.2f}\n", text, objects.other);
}

namespace {

/// The faults in spite of which the pick went on, one a line.
std::string survived_text(const skills::PickResult& result) {
  std::string text;
  for (const skills::FaultReport& report : result.survived) {
    text += fmt::format("went on after {:.2f} s in spite of {}: {}\n", report.time,
                        to_string(report.fault), report.detail);
  }
  return text;
}

std::string end_text(const evaluation::Trial& trial, const std::vector<std::string>& names) {
  const skills::FaultReport& fault = trial.result.fault;
  if (fault) {
    return fmt::format("stopped after {:.2f} s: {}: {}", fault.time, to_string(fault.fault),
                       fault.detail);
  }
  if (trial.result.attempts == 0 && !trial.result.phases.empty()) {
    return "refused: " + trial.result.phases.back().outcome;
  }
  if (trial.result.failed_phase == evaluation::kUnstable) {
    return "gave up: the simulation became unstable";
  }
  if (!trial.result.held) return "gave up: " + trial.result.failed_phase + " failed";
  return objects_text(trial, names) + estimate_text(trial);
}

}  // namespace

std::string outcome_text(const evaluation::Trial& trial, const std::vector<std::string>& names) {
  return survived_text(trial.result) + end_text(trial, names);
}

nlohmann::json trial_json(const evaluation::Trial& trial, const std::vector<std::string>& names) {
  const bool put = !trial.place || trial.place->status == skills::PlaceStatus::placed;
  const skills::FaultReport& fault = trial.result.fault;
  const bool ok = trial.result.held && trial.metrics.has_pose && put && !fault;
  json phases = json::array();
  for (const auto& report : trial.result.phases) phases.push_back(phase_json(report));
  if (trial.place) {
    for (const auto& report : trial.place->phases) phases.push_back(phase_json(report));
  }
  json failed_phase = nullptr;
  if (!trial.result.failed_phase.empty()) failed_phase = trial.result.failed_phase;
  if (trial.place && !trial.place->failed_phase.empty()) failed_phase = trial.place->failed_phase;
  return {{"status", fault ? "fault"
                     : ok  ? "ok"
                           : "failed"},
          {"faults", faults_json(trial.result)},
          {"failed_phase", failed_phase},
          {"held", trial.result.held},
          {"lifted", trial.metrics.lifted},
          {"placed", trial.place_metrics.placed},
          {"place", place_json(trial)},
          {"attempts", trial.result.attempts},
          {"robot_seconds", trial.robot_seconds},
          {"slip_mm", 1e3 * trial.metrics.slip},
          {"tip_force", trial.metrics.tip_force},
          {"limited_commands", trial.result.limited_commands},
          {"peak_load", trial.metrics.peak_load},
          {"peak_tip_force", trial.metrics.peak_tip_force},
          {"explored_motion_mm", 1e3 * trial.metrics.explored_motion},
          {"pose_ok_before_lift", trial.metrics.pose_ok_before_lift},
          {"pose_ok_before_probe", trial.metrics.pose_ok_before_probe},
          {"pose_ok_tracked", trial.metrics.pose_ok_tracked},
          {"tracked_share", trial.metrics.tracked_share},
          {"probes", trial.metrics.probes},
          {"regrasps", trial.result.regrasps},
          {"stable_pose", trial.start.stable_pose},
          {"estimate", estimate_json(trial, names)},
          {"T_world_object_true", to_json(trial.metrics.T_world_object)},
          {"phases", phases}};
}

}  // namespace palpate::app
