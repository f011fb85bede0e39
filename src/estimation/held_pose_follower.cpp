// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/held_pose_follower.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimation/log_evidence.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::estimation {
namespace {

constexpr std::size_t kKept = 100;    // readings
constexpr double kUnfollowed = 1e-3;  // probability that what was known does not hold
constexpr double kSamePlace = 0.003;  // m between contacts of which one adds no information
constexpr double kSameNormal = 0.9;   // cosine between their normals
constexpr double kNever = -1e9;       // s

/// Of a motion with these standard deviations (rad, m) per axis.
Matrix6d motion_covariance(double turn, double way) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(turn * turn), Eigen::Vector3d::Constant(way * way);
  return variance.asDiagonal();
}

/// Whether a contact is of the same finger as one of those, at the same place.
bool known_among(const tactile::Contact& contact, const std::vector<tactile::Contact>& contacts) {
  return std::any_of(contacts.begin(), contacts.end(), [&](const tactile::Contact& other) {
    return other.finger == contact.finger && (other.p - contact.p).norm() < kSamePlace &&
           (!contact.has_normal() || other.n.dot(contact.n) > kSameNormal);
  });
}

}  // namespace

HeldPoseFollower::HeldPoseFollower(const geometry::ObjectModel& object, hand::Description hand,
                                   HeldPoseOptions options, std::uint64_t seed)
    : object_(object),
      hand_(std::move(hand)),
      options_(std::move(options)),
      random_(seed, "held pose"),
      asked_at_(kNever) {}

void HeldPoseFollower::update(const hand::HandReading& reading) {
  auto& readings = log_.readings;
  if (!readings.empty() && reading.time < readings.back().time) restart(reading.time);
  if (!readings.empty() && reading.time - readings.back().time > options_.lost_after) {
    restart(reading.time);  // what was sensed before is not averaged with what is now
  }
  readings.push_back(reading);
  if (readings.size() >= 2 * kKept) {
    readings.erase(readings.begin(), readings.end() - static_cast<std::ptrdiff_t>(kKept));
  }
  const Eigen::Isometry3d before = T_world_palm_;
  T_world_palm_ =
      reading.mount.pose() *
      hand::forward_kinematics(hand_, reading.joints)[static_cast<std::size_t>(hand_.palm)];
  if (hand::touching_fingers(reading) >= options_.fingers) {
    touched_at_ = reading.time;
    motion_ = T_world_palm_ * before.inverse() * motion_;
  } else if (reading.time - touched_at_ > options_.lost_after) {
    forget();
  }  // else it stays where it is, whatever the palm does
}

void HeldPoseFollower::begin(const localization::Posterior& posterior) {
  known_ = posterior;
  known_at_ = touched_at_ = log_.readings.back().time;
  motion_of_known_ = motion_;
  used_ = contacts();
}

void HeldPoseFollower::restart(double time) {
  forget();
  log_.readings.clear();
  touched_at_ = time;
  asked_at_ = kNever;
}

void HeldPoseFollower::forget() {
  known_ = {};
  ++epoch_;
}

bool HeldPoseFollower::due() const {
  if (log_.readings.empty()) return false;
  const hand::HandReading& last = log_.readings.back();
  return hand::touching_fingers(last) >= options_.fingers &&
         last.time - asked_at_ >= options_.period - 0.5 * hand::kTick;
}

/// The motion of the object in the world since the last estimate.
Eigen::Isometry3d HeldPoseFollower::carried() const { return motion_ * motion_of_known_.inverse(); }

localization::PosePrior HeldPoseFollower::prior() const {
  const hand::HandReading& last = log_.readings.back();
  const double periods = std::max(1.0, (last.time - known_at_) / options_.period);
  localization::Posterior moved = known_;
  transform(last.mount.pose().inverse() * carried(), moved);
  const auto after = [&](double turn, double way) {
    return localization::prior_from_modes(moved, periods * motion_covariance(turn, way));
  };
  localization::PosePrior prior;
  localization::append(after(options_.rotation_sigma, options_.translation_sigma),
                       1 - options_.slip_share, prior);
  localization::append(after(options_.slip_rotation, options_.slip_translation),
                       options_.slip_share, prior);
  localization::spread_elsewhere(kUnfollowed, prior);
  return prior;
}

HeldPoseFollower::Task HeldPoseFollower::task() {
  asked_at_ = log_.readings.back().time;
  Task task{log_, motion_, std::nullopt, std::nullopt, ++tasks_, epoch_};
  if (known_.modes.empty()) return task;
  if (has_new_contacts()) {
    task.prior = prior();
  } else {
    task.known = posterior();
  }
  return task;
}

std::vector<tactile::Contact> HeldPoseFollower::contacts() const {
  return evidence_in_hand(hand_, log_, {log_.readings.size() - 1, true}, object_.object().mass,
                          options_.estimation)
      .contacts;
}

bool HeldPoseFollower::has_new_contacts() const {
  const auto now = contacts();
  return std::any_of(now.begin(), now.end(),
                     [&](const auto& contact) { return !known_among(contact, used_); });
}

HeldPoseEstimate HeldPoseFollower::estimate(const Task& task) const {
  const std::size_t present = task.log.readings.size() - 1;
  localization::Evidence evidence = evidence_in_hand(hand_, task.log, {present, true},
                                                     object_.object().mass, options_.estimation);
  const Eigen::Isometry3d T_world_mount = task.log.readings[present].mount.pose();
  HeldPoseEstimate estimate;
  if (task.known) {
    estimate.posterior = *task.known;
  } else {
    evidence.prior = task.prior;
    estimate.posterior =
        localization::localize(object_, evidence, random_.fork("estimate", task.number),
                               task.prior ? options_.estimation.search : options_.first);
    transform(T_world_mount, estimate.posterior);
  }
  estimate.contacts = std::move(evidence.contacts);
  for (auto& contact : estimate.contacts) transform(T_world_mount, contact);
  return estimate;
}

void HeldPoseFollower::accept(const Task& task, HeldPoseEstimate estimate) {
  if (task.known || task.epoch != epoch_ || estimate.posterior.residual_mass() >= 1) return;
  use(estimate.contacts, task.log.readings.back().mount.pose().inverse());
  known_ = std::move(estimate.posterior);
  known_at_ = task.log.readings.back().time;
  motion_of_known_ = task.motion;
}

/// Remembers where each finger touched last when that was reckoned with.
void HeldPoseFollower::use(std::vector<tactile::Contact> contacts,
                           const Eigen::Isometry3d& T_mount_world) {
  for (auto& contact : contacts) transform(T_mount_world, contact);
  std::erase_if(used_, [&](const tactile::Contact& before) {
    return std::any_of(contacts.begin(), contacts.end(), [&](const tactile::Contact& contact) {
      return contact.finger == before.finger;
    });
  });
  used_.insert(used_.end(), contacts.begin(), contacts.end());
}

localization::Posterior HeldPoseFollower::posterior() const {
  localization::Posterior now = known_;
  transform(carried(), now);
  return now;
}

}  // namespace palpate::estimation
