// SPDX-License-Identifier: Apache-2.0
#include "evaluation/evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/core/statistics.hpp"
#include "palpate/hand/tip_forces.hpp"

namespace palpate::evaluation {
namespace {

constexpr double kTouching = 0.1;   // N
constexpr double kLifted = 0.05;    // m above the table
constexpr double kMaxSlip = 0.010;  // m
constexpr localization::PoseTolerance kTight{2.5 * std::numbers::pi / 180, 0.0035};
constexpr localization::PoseTolerance kPlaceTight{3 * std::numbers::pi / 180, 0.005};
constexpr double kSameSide = 5 * std::numbers::pi / 180;  // rad
constexpr double kLeftHand = 0.025;                       // m of motion in the hand

double median_tip_force(const hand::HandReading& reading) {
  std::vector<double> forces;
  for (int finger = 0; finger < static_cast<int>(reading.contacts.size()); ++finger) {
    const double force = hand::tip_force(reading, finger);
    if (force > kTouching) forces.push_back(force);
  }
  return forces.empty() ? 0 : median(forces);
}

}  // namespace

void Evaluator::observe(const hand::HandReading& reading) {
  const simulation::Truth truth = world_.truth();
  moments_.push_back({reading.mount.pose().inverse() * truth.T_world_object, truth.lowest_point});
}

TrialMetrics Evaluator::metrics(const skills::PickResult& result, const estimation::EventLog& log,
                                const skills::LiftOptions& lift,
                                const std::vector<Eigen::Matrix3d>& symmetries) const {
  TrialMetrics metrics;
  metrics.T_world_object = world_.truth().T_world_object;
  if (const auto held = log.at(estimation::TouchEvent::held); held && !world_.diverged()) {
    const auto hold = static_cast<std::size_t>(std::lround(lift.hold / hand::kTick));
    const std::size_t first = *held - std::min(*held, hold);
    const auto& before = moments_[first].T_mount_object.translation();
    double lowest = moments_[first].lowest_point;
    for (std::size_t i = first; i <= *held; ++i) {
      metrics.slip =
          std::max(metrics.slip, (moments_[i].T_mount_object.translation() - before).norm());
      lowest = std::min(lowest, moments_[i].lowest_point);
    }
    metrics.tip_force = median_tip_force(log.readings[*held]);
    metrics.lifted = result.held && lowest > kLifted && metrics.slip < kMaxSlip;
  }
  const auto closed = log.all(estimation::TouchEvent::closed);
  if (!closed.empty()) {
    metrics.pose_ok_before_lift = right_in_hand(result.before_lift, closed.back(), log, symmetries);
    metrics.pose_ok_before_probe =
        right_in_hand(result.before_probe, closed.front(), log, symmetries);
  }
  evaluate_tracked(result, symmetries, metrics);
  metrics.probes = static_cast<int>(log.count(estimation::TouchEvent::probed));
  metrics.explored_motion = motion_while_explored(log);
  const auto& posterior = result.estimate.posterior;
  metrics.has_pose = !posterior.modes.empty();
  if (metrics.has_pose) {
    const auto& truth = metrics.T_world_object;
    const auto& best = posterior.modes[0].T_frame_object;
    metrics.error = localization::pose_error(best, truth, symmetries);
    metrics.error_no_symmetry =
        localization::pose_error(best, truth, {Eigen::Matrix3d::Identity()});
    metrics.pose_ok = within(metrics.error);
    metrics.pose_tight = within(metrics.error, kTight);
    metrics.covered = localization::covers(posterior, truth, symmetries);
    metrics.status = posterior.status;
    metrics.probability = localization::best_probability(posterior);
    if (const auto& axis = posterior.modes[0].free_axis) metrics.free_extent = axis->extent;
  }
  return metrics;
}

void Evaluator::evaluate_tracked(const skills::PickResult& result,
                                 const std::vector<Eigen::Matrix3d>& symmetries,
                                 TrialMetrics& metrics) const {
  if (!result.tracked || result.tracked->looks.empty()) return;
  int right = 0;
  for (const auto& look : result.tracked->looks) {
    const auto error = localization::pose_error(look.T_mount_object,
                                                moments_[look.reading].T_mount_object, symmetries);
    metrics.pose_ok_tracked = within(error);
    right += metrics.pose_ok_tracked;
  }
  metrics.tracked_share = right / static_cast<double>(result.tracked->looks.size());
}

bool Evaluator::right_in_hand(const std::optional<estimation::HeldPoseEstimate>& estimate,
                              std::size_t closed, const estimation::EventLog& log,
                              const std::vector<Eigen::Matrix3d>& symmetries) const {
  if (!estimate || estimate->posterior.modes.empty()) return false;
  const auto truth = log.readings[closed].mount.pose() * moments_[closed].T_mount_object;
  const auto& best = estimate->posterior.modes[0].T_frame_object;
  return within(localization::pose_error(best, truth, symmetries));
}

Eigen::Isometry3d Evaluator::object_at(const estimation::EventLog& log, std::size_t reading) const {
  return log.readings[reading].mount.pose() * moments_[reading].T_mount_object;
}

bool Evaluator::left_the_hand(const estimation::EventLog& log, std::size_t first,
                              std::size_t last) const {
  const Eigen::Vector3d start = moments_[first].T_mount_object.translation();
  for (std::size_t i = first; i <= std::min(last, log.readings.size() - 1); ++i) {
    if ((moments_[i].T_mount_object.translation() - start).norm() > kLeftHand) return true;
  }
  return false;
}

PlaceMetrics Evaluator::place_metrics(const skills::PlaceResult& result,
                                      const skills::PlaceTarget& target,
                                      const estimation::EventLog& log,
                                      const geometry::KnownObject& object) const {
  PlaceMetrics metrics;
  const estimation::EventLog picked = log.until(estimation::TouchEvent::held);
  const std::size_t held = picked.readings.size() - 1;
  std::size_t release = log.until(estimation::TouchEvent::placed).readings.size() - 1;
  if (release < held) release = log.readings.size() - 1;  // it was not placed since it was picked
  metrics.dropped = left_the_hand(log, held, release);
  const auto closed = picked.at(estimation::TouchEvent::closed);
  const Eigen::Isometry3d before = object_at(log, closed ? *closed : held);
  metrics.T_world_target = skills::target_pose(
      target, object, skills::nearest_stable_pose(object, before.linear()).stable_pose);
  const Eigen::Isometry3d after = world_.truth().T_world_object;
  const auto apart = [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return localization::pose_error(a, b, object.symmetries);
  };
  metrics.error = apart(after, metrics.T_world_target);
  metrics.in_stable_pose =
      skills::same_side_up(object, after.linear(), metrics.T_world_target.linear(), kSameSide);
  if (!result.T_world_placed || world_.diverged()) return metrics;
  const Eigen::Isometry3d at_release = object_at(log, release);
  metrics.estimate = apart(*result.T_world_placed, at_release);
  metrics.release = apart(after, at_release);
  const bool released_for_good =
      result.status == skills::PlaceStatus::placed || result.status == skills::PlaceStatus::missing;
  metrics.placed = released_for_good && within(metrics.error);
  metrics.tight = metrics.placed && within(metrics.error, kPlaceTight);
  metrics.wrong = result.certain && !result.on_the_way && !metrics.placed;
  return metrics;
}

double Evaluator::motion_while_explored(const estimation::EventLog& log) const {
  const auto place = [&](std::size_t i) -> Eigen::Vector3d {
    return object_at(log, i).translation();
  };
  std::optional<std::size_t> first, last;
  for (const auto& moment : log.since_release()) {
    if (moment.event == estimation::TouchEvent::guarded_move && !first) first = moment.reading;
    if (estimation::ends_guarded_move(moment.event)) last = moment.reading;
  }
  return first && last ? (place(*last) - place(*first)).norm() : 0;
}

}  // namespace palpate::evaluation
