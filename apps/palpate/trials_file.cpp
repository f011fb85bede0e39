// SPDX-License-Identifier: Apache-2.0
#include "trials_file.hpp"

#include <fmt/format.h>

#include <utility>

#include "palpate/core/angle.hpp"
#include "palpate/core/file.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::app {
namespace {

/// Empty where there is no error to report.
std::string error_cells(bool known, const localization::PoseError& error) {
  if (!known) return ",";
  return fmt::format("{:.3f},{:.3f}", kDegreesPerRadian * error.rotation, 1e3 * error.translation);
}

std::string pick_cells(const evaluation::Trial& trial) {
  const evaluation::TrialMetrics& metrics = trial.metrics;
  const auto& modes = trial.result.estimate.posterior.modes;
  return fmt::format(
      "{},{:d},{},{},{:d},{:.4f},{:.4f},{:d},{:d},{:d},{:d},{:d},{:.3f},{:d},{},{},{:.4f},{:.1f},{}"
      ",{},{:.3f},{:.3f},"
      "{:.3f},{}",
      trial.start.stable_pose, metrics.lifted, trial.result.attempts, trial.result.regrasps,
      metrics.object_ok, metrics.object_probability, metrics.other_probability, metrics.pose_ok,
      metrics.pose_tight, metrics.pose_ok_before_lift, metrics.pose_ok_before_probe,
      metrics.pose_ok_tracked, metrics.tracked_share, metrics.covered,
      modes.empty() ? "" : fmt::format("{:.4f}", modes[0].weight), to_string(metrics.status),
      metrics.probability, kDegreesPerRadian * metrics.free_extent, metrics.probes,
      error_cells(metrics.has_pose, metrics.error), 1e3 * metrics.slip,
      1e3 * metrics.explored_motion, metrics.tip_force, trial.result.failed_phase);
}

std::string place_cells(const evaluation::Trial& trial) {
  if (!trial.place) return ",,,,,,,,";
  const evaluation::PlaceMetrics& metrics = trial.place_metrics;
  return fmt::format(
      "{},{:d},{:d},{:d},{:d},{:d},{},{:d}", to_string(trial.place->status), trial.place->certain,
      metrics.placed, metrics.tight, metrics.wrong, metrics.dropped,
      error_cells(trial.place->T_world_placed.has_value(), metrics.error), metrics.in_stable_pose);
}

}  // namespace

TrialsFile::TrialsFile(std::filesystem::path path, bool place)
    : path_(std::move(path)), place_(place) {
  text_ =
      "object,seed,stable_pose,lifted,attempts,regrasps,object_ok,object_probability,other_"
      "probability,"
      "pose_ok,pose_tight,pose_ok_before_lift,"
      "pose_ok_before_probe,pose_ok_tracked,tracked_share,covered,weight,"
      "pose_status,probability,free_axis_deg,probes,"
      "rotation_error_deg,translation_error_mm,slip_mm,explored_motion_mm,tip_force,failed_phase";
  if (place_)
    text_ += ",place_status,certain,placed,tight,wrong,dropped,place_deg,place_mm,in_stable_pose";
  text_ += '\n';
}

void TrialsFile::add(const std::string& object, std::uint64_t seed,
                     const evaluation::Trial& trial) {
  text_ += fmt::format("{},{},{}", object, seed, pick_cells(trial));
  if (place_) text_ += fmt::format(",{}", place_cells(trial));
  text_ += '\n';
}

void TrialsFile::write() const { write_file_atomically(path_, text_); }

}  // namespace palpate::app
