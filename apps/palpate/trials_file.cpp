// SPDX-License-Identifier: Apache-2.0
#include "trials_file.hpp"

#include <fmt/format.h>

#include <numbers>
#include <utility>

#include "palpate/core/file.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::app {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

/// Empty where there is no error to tell.
std::string error_cells(bool known, const localization::PoseError& error) {
  if (!known) return ",";
  return fmt::format("{:.3f},{:.3f}", kDegrees * error.rotation, 1e3 * error.translation);
}

std::string pick_cells(const evaluation::Trial& trial) {
  const evaluation::Judgement& judgement = trial.judgement;
  const auto& modes = trial.result.estimate.posterior.modes;
  return fmt::format(
      "{},{:d},{},{},{:d},{:d},{:d},{:d},{:d},{:.3f},{:d},{},{},{},{:.3f},{:.3f},{:.3f},{}",
      trial.start.stance, judgement.lifted, trial.result.attempts, trial.result.regrasps,
      judgement.pose_ok, judgement.pose_tight, judgement.pose_ok_before_lift,
      judgement.pose_ok_before_probe, judgement.pose_ok_tracked, judgement.tracked_share,
      judgement.truth_in_modes, modes.empty() ? "" : fmt::format("{:.4f}", modes[0].weight),
      judgement.probes, error_cells(judgement.has_pose, judgement.error), 1e3 * judgement.slip,
      1e3 * judgement.explored_motion, judgement.tip_force, trial.result.failed_phase);
}

std::string place_cells(const evaluation::Trial& trial) {
  if (!trial.place) return ",,,,,,,,";
  const evaluation::PlaceJudgement& judgement = trial.place_judgement;
  return fmt::format(
      "{},{:d},{:d},{:d},{:d},{:d},{},{:d}", to_string(trial.place->status), trial.place->certain,
      judgement.placed, judgement.tight, judgement.wrong, judgement.dropped,
      error_cells(trial.place->T_world_placed.has_value(), judgement.error), judgement.in_stance);
}

}  // namespace

TrialsFile::TrialsFile(std::filesystem::path path, bool place)
    : path_(std::move(path)), place_(place) {
  text_ =
      "object,seed,stance,lifted,attempts,regrasps,pose_ok,pose_tight,pose_ok_before_lift,"
      "pose_ok_before_probe,pose_ok_tracked,tracked_share,truth_in_modes,weight,probes,"
      "rotation_error_deg,translation_error_mm,slip_mm,explored_motion_mm,tip_force,failed_phase";
  if (place_)
    text_ += ",place_status,certain,placed,tight,wrong,dropped,place_deg,place_mm,in_stance";
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
