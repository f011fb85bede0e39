// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/held_pose_follower.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/log_evidence.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kKept = 100;       // readings
constexpr std::size_t kFewContacts = 2;  // which cannot overrule what is expected
constexpr double kFloorOfFewContacts = 1e-6;
constexpr double kNever = -1e9;  // s

int fingers_that_touch(const hand::HandReading& reading) {
  return static_cast<int>(std::count_if(reading.contacts.begin(), reading.contacts.end(),
                                        [](const auto& finger) { return !finger.empty(); }));
}

}  // namespace

HeldPoseFollower::HeldPoseFollower(const geometry::ObjectModel& object, hand::Description hand,
                                   HeldPoseOptions options, std::uint64_t seed)
    : object_(object),
      hand_(std::move(hand)),
      options_(std::move(options)),
      random_(seed, "held pose"),
      asked_at_(kNever) {}

void HeldPoseFollower::feel(const hand::HandReading& reading) {
  auto& readings = log_.readings;
  readings.push_back(reading);
  if (readings.size() >= 2 * kKept) {
    readings.erase(readings.begin(), readings.end() - static_cast<std::ptrdiff_t>(kKept));
  }
  const Eigen::Isometry3d before = carried();
  T_world_palm_ =
      reading.base.pose() *
      hand::forward_kinematics(hand_, reading.joints)[static_cast<std::size_t>(hand_.palm)];
  if (fingers_that_touch(reading) >= options_.fingers) {
    touched_at_ = reading.time;
  } else if (reading.time - touched_at_ > options_.lost_after) {
    forget();
  } else {  // it stays where it is, whatever the palm does
    palm_of_estimate_ = before.inverse() * T_world_palm_;
  }
}

void HeldPoseFollower::forget() {
  known_ = {};
  ++epoch_;
}

bool HeldPoseFollower::due() const {
  if (log_.readings.empty()) return false;
  const hand::HandReading& last = log_.readings.back();
  return fingers_that_touch(last) >= options_.fingers &&
         last.time - asked_at_ >= options_.period - 0.5 * hand::kTick;
}

/// The motion of the object in the world since the last estimate.
Eigen::Isometry3d HeldPoseFollower::carried() const {
  return T_world_palm_ * palm_of_estimate_.inverse();
}

localization::PosePrior HeldPoseFollower::prior() const {
  const hand::HandReading& last = log_.readings.back();
  const double periods = std::max(1.0, (last.time - known_at_) / options_.period);
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(std::pow(options_.turn_sigma, 2)),
      Eigen::Vector3d::Constant(std::pow(options_.way_sigma, 2));
  localization::Posterior moved = known_;
  transform(last.base.pose().inverse() * carried(), moved);
  const Matrix6d covariance = (periods * variance).asDiagonal();
  return localization::prior_from(moved, covariance);
}

HeldPoseFollower::Task HeldPoseFollower::task() {
  asked_at_ = log_.readings.back().time;
  Task task{log_, T_world_palm_, std::nullopt, ++tasks_, epoch_};
  if (!known_.modes.empty()) task.prior = prior();
  return task;
}

HeldPoseEstimate HeldPoseFollower::estimate(const Task& task) const {
  const std::size_t present = task.log.readings.size() - 1;
  localization::Evidence evidence = evidence_in_hand(hand_, task.log, {present, true},
                                                     object_.object().mass, options_.estimation);
  evidence.prior = task.prior;
  if (evidence.prior && evidence.contacts.size() <= kFewContacts) {
    evidence.prior->floor = kFloorOfFewContacts;
  }
  HeldPoseEstimate estimate;
  estimate.posterior =
      localization::localize(object_, evidence, random_.fork("estimate", task.number),
                             task.prior ? options_.estimation.search : options_.first);
  estimate.contacts = std::move(evidence.contacts);
  const Eigen::Isometry3d T_world_base = task.log.readings[present].base.pose();
  transform(T_world_base, estimate.posterior);
  for (auto& contact : estimate.contacts) transform(T_world_base, contact);
  return estimate;
}

void HeldPoseFollower::accept(const Task& task, HeldPoseEstimate estimate) {
  if (task.epoch != epoch_ || estimate.posterior.unlisted() >= 1) return;
  known_ = std::move(estimate.posterior);
  known_at_ = task.log.readings.back().time;
  palm_of_estimate_ = task.T_world_palm;
}

localization::Posterior HeldPoseFollower::posterior() const {
  localization::Posterior now = known_;
  transform(carried(), now);
  return now;
}

}  // namespace palpate::estimation
