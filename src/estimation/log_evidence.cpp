// SPDX-License-Identifier: Apache-2.0
#include "estimation/log_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "estimation/event_window.hpp"
#include "estimation/in_hand_motion.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"

namespace palpate::estimation {

using localization::Evidence;

namespace {

constexpr double kTouchMargin = 0.004;   // m before a touch that do not count as free
constexpr double kElsewhere = 0.004;     // m that a fingertip has gone when it probes
constexpr double kSweptSpacing = 0.008;  // m between the places of a swept fingertip
constexpr double kForceSigma = 0.02;     // N, of a mean force
constexpr double kPush = 0.0004;         // m by which a touch pushes an object of kPushedMass
constexpr double kPushedMass = 0.05;     // kg; heavier ones move by less, in proportion

std::vector<localization::FreeSphere> hand_spheres(const hand::Description& hand,
                                                   const hand::HandReading& reading) {
  const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
  std::vector<localization::FreeSphere> spheres;
  for (const auto& sphere : hand.spheres) {
    spheres.push_back(
        {T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center, sphere.radius});
  }
  return spheres;
}

/// The finger that a guarded move is made with: its fingertip is the hand's lowest.
int probing_finger(const hand::Description& hand, const hand::HandReading& reading) {
  const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
  const Eigen::Matrix3d R_world_mount = reading.mount.pose().linear();
  int lowest = -1;
  double low = std::numeric_limits<double>::infinity();
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    if (finger == hand.thumb) continue;
    const auto i = static_cast<std::size_t>(finger);
    const auto& T = T_mount_link[static_cast<std::size_t>(hand.fingers[i].link)];
    const double height = (R_world_mount * (T * hand.fingers[i].tip.b)).z();
    if (height >= low) continue;
    low = height;
    lowest = finger;
  }
  return lowest;
}

/// Where the probing fingertip has been between two readings, without the last `margin` metres.
void add_swept_tip(const hand::Description& hand, const EventLog& log, std::size_t first,
                   std::size_t last, double margin, std::vector<localization::FreeSphere>& swept) {
  const auto T_mount_link = hand::forward_kinematics(hand, log.readings[first].joints);
  const int finger = probing_finger(hand, log.readings[first]);
  const int tip = hand.fingers[static_cast<std::size_t>(finger)].link;
  const Eigen::Vector3d end = log.readings[last].mount.xyz;
  Eigen::Vector3d previous = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t i = first; i <= last; ++i) {
    const auto& mount = log.readings[i].mount;
    if ((mount.xyz - end).norm() < margin) break;
    if ((mount.xyz - previous).norm() < kSweptSpacing) continue;
    previous = mount.xyz;
    for (const auto& sphere : hand.spheres) {
      if (sphere.link != tip) continue;
      swept.push_back(
          {mount.pose() * T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center,
           sphere.radius});
    }
  }
}

/// Lasting contacts without the error of the links, which all contacts of a finger share.
std::vector<tactile::Contact> mean_contacts(std::span<const hand::HandReading> window,
                                            const hand::Description& hand,
                                            const tactile::ContactErrorModel& errors) {
  auto contacts = tactile::lasting_contacts(window, hand, errors);
  for (auto& contact : contacts) {
    const double shared = tactile::link_offset_sigma(hand, contact.finger);
    contact.point_sigma = std::sqrt(contact.point_sigma * contact.point_sigma - shared * shared);
  }
  return contacts;
}

/// The links' misplacement displaces all contacts of a finger alike, in the mount's axes.
localization::CommonModeBias finger_offset(const hand::Description& hand, int finger) {
  localization::CommonModeBias offset;
  offset.sigma = tactile::link_offset_sigma(hand, finger);
  return offset;
}

/// Groups contacts by finger.
void share_offsets(const hand::Description& hand, Evidence& evidence) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    auto offset = finger_offset(hand, finger);
    for (std::size_t k = 0; k < evidence.contacts.size(); ++k) {
      if (evidence.contacts[k].finger == finger) offset.members.push_back({k});
    }
    if (offset.sigma > 0 && !offset.members.empty()) evidence.offsets.push_back(std::move(offset));
  }
}

/// Which fingers were at another posture than at the moment of closing.
Fingers moved_fingers(const hand::Description& hand, std::span<const hand::HandReading> closed,
                      std::span<const hand::HandReading> probed) {
  const auto T_closed = hand::forward_kinematics(hand, tactile::mean_joints(closed));
  const auto T_probed = hand::forward_kinematics(hand, tactile::mean_joints(probed));
  Fingers moved{};
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    const auto link = static_cast<std::size_t>(hand.fingers[finger].link);
    moved[finger] =
        (T_closed[link] * hand.fingers[finger].tip.b - T_probed[link] * hand.fingers[finger].tip.b)
            .norm() > kElsewhere;
  }
  return moved;
}

/// Adds contacts of some fingers that are carried along with the object to the present.
void add_carried(std::vector<tactile::Contact> contacts, const Fingers& fingers,
                 const Eigen::Isometry3d& motion, const EstimationOptions& options,
                 Evidence& evidence) {
  for (auto& contact : contacts) {
    if (!fingers[static_cast<std::size_t>(contact.finger)]) continue;
    transform(motion, contact);
    contact.point_sigma = std::hypot(contact.point_sigma, options.probe_motion);
    evidence.contacts.push_back(contact);
  }
}

/// The last moment before a probe at which all fingers held the object.
std::size_t holding_before(const EventLog& log, std::size_t probe) {
  std::size_t latest = log.all(TouchEvent::closed).front();
  for (const TouchEvent event : {TouchEvent::closed, TouchEvent::held}) {
    for (const std::size_t reading : log.all(event)) {
      if (reading < probe) latest = std::max(latest, reading);
    }
  }
  return latest;
}

/// Adds what a finger found at another spot while the others held the object: its touch, if it
/// made one, and the space that it takes.
void add_probe(const hand::Description& hand, const EventLog& log, std::size_t probe,
               std::size_t present, const EstimationOptions& options, Evidence& evidence) {
  const auto probed = event_window(log, TouchEvent::probed, probe, options);
  const auto holding = event_window(log, TouchEvent::closed, holding_before(log, probe), options);
  const auto moved = moved_fingers(hand, holding, probed);
  const auto motion = in_hand_motion(hand, log, probe, present, options.errors, moved).T;
  add_carried(mean_contacts(probed, hand, options.errors), moved, motion, options, evidence);
  if (!options.free_space) return;
  const auto T_mount_link = hand::forward_kinematics(hand, tactile::mean_joints(probed));
  for (const auto& sphere : hand.spheres) {
    for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
      if (!moved[finger] || sphere.link != hand.fingers[finger].link) continue;
      evidence.free_space.push_back(
          {motion * T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center,
           sphere.radius});
    }
  }
}

/// Adds where the table was when the held object touched it, carried along with the object to the
/// present. Each later touch may have turned it in the hand.
void add_table_touches(const hand::Description& hand, const EventLog& log, std::size_t present,
                       const EstimationOptions& options, Evidence& evidence) {
  const auto touches = log.all(TouchEvent::table_touched);
  for (std::size_t k = 0; k < touches.size(); ++k) {
    const Eigen::Isometry3d T_mount_table =
        log.readings[touches[k]].mount.pose().inverse() * log.T_world_table;
    const auto motion = in_hand_motion(hand, log, touches[k], present, options.errors).T;
    const Eigen::Isometry3d T = motion * T_mount_table;
    const Eigen::Vector3d normal = T.linear().col(2);
    const double later = std::sqrt(static_cast<double>(touches.size() - 1 - k));
    evidence.planes.push_back(
        {normal, normal.dot(T.translation()),
         std::hypot(options.table_touch_sigma, later * options.probe_motion)});
  }
}

/// What the fingertips do to the object that hangs in them, in the hand's mount.
localization::ForceBalance balance_of(const std::vector<tactile::Contact>& contacts, double mass,
                                      const Eigen::Isometry3d& T_world_mount,
                                      const EstimationOptions& options) {
  localization::ForceBalance balance;
  for (const auto& contact : contacts) balance.pushes.push_back({contact.p, contact.n, contact.f});
  balance.weight = -kGravity * mass * T_world_mount.linear().row(2).transpose();
  balance.force_sigma = kForceSigma;
  balance.torsional_friction_radius = options.torsional_friction_radius;
  return balance;
}

}  // namespace

void transform(const Eigen::Isometry3d& T_new_old, tactile::Contact& contact) {
  contact.p = T_new_old * contact.p;
  contact.n = T_new_old.linear() * contact.n;
  contact.f = T_new_old.linear() * contact.f;
}

Evidence evidence_of_guarded_moves(const hand::Description& hand, const EventLog& log,
                                   const EstimationOptions& options, double mass,
                                   std::size_t skipped) {
  const double push = kPush * std::min(1.0, kPushedMass / mass);
  Evidence evidence;
  auto offset = finger_offset(hand, hand.thumb == 0 ? 1 : 0);
  std::size_t guarded_move = 0, count = 0;
  for (const auto& moment : log.since_release()) {
    if (moment.event == TouchEvent::guarded_move) guarded_move = moment.reading;
    if (!ends_guarded_move(moment.event)) continue;
    if (count++ < skipped) continue;
    const bool touched = moment.event == TouchEvent::touched;
    add_swept_tip(hand, log, guarded_move, moment.reading, touched ? kTouchMargin : 0.0,
                  evidence.free_space);
    if (!touched) continue;
    const int finger = probing_finger(hand, log.readings[moment.reading]);
    if (offset.members.empty()) offset = finger_offset(hand, finger);
    const Eigen::Isometry3d T_world_mount = log.readings[moment.reading].mount.pose();
    const auto window = event_window(log, moment.event, moment.reading, options);
    for (auto contact : mean_contacts(window, hand, options.errors)) {
      transform(T_world_mount, contact);
      contact.point_sigma = std::hypot(contact.point_sigma, push);
      offset.members.push_back({evidence.contacts.size(), T_world_mount.linear()});
      evidence.contacts.push_back(contact);
    }
  }
  if (offset.sigma > 0) evidence.offsets.push_back(std::move(offset));
  return evidence;
}

Evidence evidence_in_hand(const hand::Description& hand, const EventLog& log,
                          const Instant& instant, double mass, const EstimationOptions& options) {
  Evidence evidence;
  const std::size_t present = instant.reading;
  const TouchEvent event = instant.hangs ? TouchEvent::held : TouchEvent::closed;
  evidence.contacts =
      mean_contacts(event_window(log, event, present, options), hand, options.errors);
  evidence.false_contact_share = options.false_contacts;
  evidence.surface_sigma = options.surface_sigma;
  evidence.penetration_sigma = options.penetration_sigma;
  if (options.free_space) evidence.free_space = hand_spheres(hand, log.readings[present]);
  if (options.balance && instant.hangs && !evidence.contacts.empty()) {
    evidence.balance =
        balance_of(evidence.contacts, mass, log.readings[present].mount.pose(), options);
  }
  if (log.at(TouchEvent::closed)) {
    for (const std::size_t probe : log.all(TouchEvent::probed)) {
      add_probe(hand, log, probe, present, options, evidence);
    }
    add_table_touches(hand, log, present, options, evidence);
  }
  share_offsets(hand, evidence);
  return evidence;
}

}  // namespace palpate::estimation
