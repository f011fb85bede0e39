// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/online_tracker.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "estimation/log_evidence.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kFew = 2;       // contacts, which cannot overrule what is expected
constexpr double kFloorOfFew = 1e-6;  // PosePrior::floor with these

}  // namespace

OnlineTracker::OnlineTracker(const geometry::ObjectModel& object, const hand::Description& hand,
                             const localization::Posterior& resting,
                             const OnlineTrackerOptions& options, std::uint64_t seed)
    : object_(object),
      hand_(hand),
      options_(options),
      random_(seed, "felt place") {  // the text seeds the stream
  if (resting.residual_mass() >= 1)
    throw BadInput("no pose from which an object could be followed");
  known_.pose.posterior = coming_.pose.posterior = resting;
}

void OnlineTracker::update(const hand::HandReading& reading) {
  log_.readings.push_back(reading);
  const auto T_mount_link = hand::forward_kinematics(hand_, reading.joints);
  palm_.push_back(reading.mount.pose() * T_mount_link[static_cast<std::size_t>(hand_.palm)]);
  follow();
  if ((log_.readings.size() - 1) % static_cast<std::size_t>(hand::whole_ticks(options_.period)) !=
      0)
    return;
  known_ = coming_;
  if (options_.estimate && hand::touching_fingers(reading) >= options_.fingers) estimate();
}

/// The object goes with the palm as long as the hand, having risen, touches it.
void OnlineTracker::follow() {
  if (moved_.empty()) {
    moved_.emplace_back(Eigen::Isometry3d::Identity());
    lowest_palm_ = palm_.front().translation().z();
    return;
  }
  const double height = palm_.back().translation().z();
  lowest_palm_ = std::min(lowest_palm_, height);
  const bool touches = hand::count_contacts(log_.readings.back()) > 0;
  if (touches && !touched_) touched_ = log_.readings.size() - 1;
  const bool carries = touches && height > lowest_palm_ + options_.lifts;
  const Eigen::Isometry3d motion = palm_.back() * palm_[palm_.size() - 2].inverse();
  moved_.push_back(carries ? motion * moved_.back() : moved_.back());
}

Eigen::Isometry3d OnlineTracker::T_world_object() const {
  const Eigen::Isometry3d& T = known_.pose.posterior.modes.front().T_frame_object;
  return moved_.empty() ? T : moved_.back() * moved_[known_.reading].inverse() * T;
}

/// Of the object at the last reading, in the hand's mount: where the last estimate has it, or gone
/// along with the palm that has touched it since.
localization::PosePrior OnlineTracker::expected() const {
  const std::size_t since = std::max(coming_.reading, touched_.value_or(palm_.size() - 1));
  const double periods = static_cast<double>(palm_.size() - 1 - since) /
                         static_cast<double>(hand::whole_ticks(options_.period));
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(std::pow(options_.rotation_sigma, 2)),
      Eigen::Vector3d::Constant(std::pow(options_.translation_sigma, 2));
  const Matrix6d covariance = (std::max(1.0, periods) * variance).asDiagonal();
  const Eigen::Isometry3d T_mount_world = log_.readings.back().mount.pose().inverse();
  localization::PosePrior prior;
  for (const Eigen::Isometry3d& motion :
       {Eigen::Isometry3d::Identity(), palm_.back() * palm_[since].inverse()}) {
    localization::Posterior moved = coming_.pose.posterior;
    transform(T_mount_world * motion, moved);
    for (auto& component : localization::prior_from_modes(moved, covariance).components) {
      component.weight /= 2;
      prior.components.push_back(component);
    }
  }
  std::stable_sort(prior.components.begin(), prior.components.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  return prior;
}

void OnlineTracker::estimate() {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t present = log_.readings.size() - 1;
  const Eigen::Isometry3d T_world_mount = log_.readings[present].mount.pose();
  localization::Evidence evidence =
      evidence_in_hand(hand_, log_, {present, true}, object_.object().mass, options_.estimation);
  evidence.prior = expected();
  if (evidence.contacts.size() <= kFew) evidence.prior->floor = kFloorOfFew;
  auto posterior = localization::localize(
      object_, evidence, random_.fork("estimate", static_cast<std::uint64_t>(present)),
      options_.estimation.search);
  if (posterior.residual_mass() < 1) {  // else the contacts leave the pose open
    transform(T_world_mount, posterior);
    for (auto& contact : evidence.contacts) transform(T_world_mount, contact);
    coming_ = {{std::move(posterior), std::move(evidence.contacts)}, present};
    ++estimates_;
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace palpate::estimation
