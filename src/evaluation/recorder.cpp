// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/recorder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>
#include <stdexcept>

#include "palpate/core/error.hpp"
#include "palpate/evaluation/credible_poses.hpp"
#include "palpate/recording/estimate_record.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::evaluation {
namespace {

/// Places of the object's centroid along the transport as it was planned: x y z of each, m.
std::vector<double> planned_path(const skills::PlaceResult& placed) {
  constexpr std::size_t kStep = 10;  // samples
  std::vector<double> path;
  for (std::size_t i = 0; i < placed.motion.samples.size(); i += kStep) {
    const Eigen::Vector3d p =
        placed.motion.samples[i].mount.pose() * placed.held.T_mount_object.translation();
    path.insert(path.end(), p.begin(), p.end());
  }
  return path;
}

}  // namespace

void Recorder::frame(const hand::HandReading& reading, const hand::HandCommand& command) {
  time_ = reading.time;
  if (world_.diverged()) throw std::runtime_error("the simulation became unstable");
  if (!sink_) return;
  const simulation::Truth truth = world_.truth();
  sink_->frame({reading, command, recording::FrameTruth{truth.T_world_object, truth.joints}});
}

void Recorder::event(estimation::TouchEvent event) {
  if (!sink_) return;
  sink_->event({time_, recording::EventKind::note, phase_, recording::touch_note(event)});
}

void Recorder::posterior(const localization::Posterior& posterior) {
  if (!sink_) return;
  sink_->event({time_, recording::EventKind::note, phase_, credible_note(posterior)});
}

void Recorder::estimate(double time, const estimation::HeldPoseEstimate& estimate) {
  if (!sink_) return;
  sink_->estimate(recording::estimate_record(time, estimate));
}

void Recorder::placement(const skills::PlaceResult& placed, const planning::Fixture& fixture) {
  if (!sink_) return;
  const auto note = [&](std::string_view what, std::span<const double> values) {
    sink_->event({time_, recording::EventKind::note, phase_,
                  fmt::format("{} {}", what, fmt::join(values, " "))});
  };
  note("target", pose_to_row_major(placed.T_world_target));
  note("path", planned_path(placed));
  for (const auto& box : fixture) {
    const auto pose = pose_to_row_major(box.T_world_box);
    std::vector<double> values(pose.begin(), pose.end());
    values.insert(values.end(), box.half_extents.begin(), box.half_extents.end());
    note("fixture", values);
  }
}

skills::PhaseObserver Recorder::phases_and(const skills::PhaseObserver& other) {
  const auto begin = [this, other](std::string_view phase, double time) {
    phase_ = phase;
    if (sink_) sink_->event({time, recording::EventKind::begin, phase_, ""});
    if (other.on_begin) other.on_begin(phase, time);
  };
  const auto end = [this, other](const skills::PhaseReport& report, double time) {
    if (sink_) {
      sink_->event({time, recording::EventKind::end, report.name,
                    std::string(skills::to_string(report.status)) + ": " + report.outcome});
    }
    if (other.on_end) other.on_end(report, time);
  };
  return {begin, end, other.on_picked, other.on_placed};
}

}  // namespace palpate::evaluation
