// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/locate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "carried_motion.hpp"
#include "load.hpp"
#include "palpate/localization/pose_prior.hpp"
#include "palpate/pipeline/feel_phase.hpp"

namespace palpate::pipeline {
namespace {

constexpr int kSlides = 2;              // how often a grasp may slide, each time
constexpr double kFarther = 3.0;        // so many times as far
constexpr double kGraspedAnew = 3.0;    // so many times as far do opening and closing anew move it
constexpr double kTouchWindow = 0.1;    // s of a touch that are averaged
constexpr double kClosedWindow = 0.15;  // s of touching before the mark `closed`
constexpr double kTouchMargin = 0.004;  // m before a touch that do not count as free
/// Shares of the sweeps that are forgotten, one after the other, while no pose explains the rest: a
/// touch may have moved the object.
constexpr std::array<double, 3> kForgotten = {0, 0.35, 0.55};
constexpr std::size_t kLeastTouches = 4;  // that are then left
constexpr double kElsewhere = 0.004;      // m that a fingertip has gone when it probes
constexpr double kSweptSpacing = 0.008;   // m between the places of a swept fingertip

using geometry::KnownObject;
using localization::Evidence;
using localization::PosePrior;
using localization::TableSupport;

double top_of(const KnownObject& object, const geometry::Stance& stance) {
  double top = -std::numeric_limits<double>::infinity();
  for (const auto& vertex : object.mesh.vertices) {
    top = std::max(top, stance.R_table_object.row(2).dot(vertex));
  }
  return top + stance.height;
}

/// Probability of each stance, given how tall the object felt.
std::vector<double> stance_weights(const KnownObject& object, std::optional<double> felt_height,
                                   const LocateOptions& options) {
  std::vector<double> weights;
  double sum = 0;
  for (const auto& stance : object.stances) {
    const double miss =
        felt_height ? (top_of(object, stance) - *felt_height) / options.felt_sigma : 0.0;
    weights.push_back(stance.probability * std::exp(-0.5 * miss * miss));
    sum += weights.back();
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double felt = sum > 0 ? weights[i] / sum : object.stances[i].probability;
    weights[i] =
        (1 - options.other_stance) * felt + options.other_stance * object.stances[i].probability;
  }
  return weights;
}

std::optional<double> felt_height(const hand::HandModel& hand, const TouchLog& log) {
  const auto felt = log.at(Mark::felt);
  if (!felt) return std::nullopt;
  return lowest_of_hand(hand, log.readings[*felt]);
}

/// The table under the object that nobody has moved yet. Misplaced links of the hand shift all that
/// it feels, so that height and place are uncertain by that much.
TableSupport resting_table(const KnownObject& object, const hand::HandModel& hand,
                           const TouchLog& log, const LocateOptions& options) {
  TableSupport table;
  table.T_frame_table = Eigen::Isometry3d::Identity();
  table.stance_weights = stance_weights(object, felt_height(hand, log), options);
  table.height_sigma = options.resting_height_sigma;
  table.half_width = options.resting_half_width;
  table.edge_sigma = 0.005;
  return table;
}

TableSupport table_at_closing(const KnownObject& object, const hand::HandModel& hand,
                              const TouchLog& log, const LocateOptions& options) {
  TableSupport table;
  const auto& closed = log.readings[*log.at(Mark::closed)];
  table.T_frame_table = closed.base.pose().inverse();
  table.stance_weights = stance_weights(object, felt_height(hand, log), options);
  table.tilt_sigma = options.tilt_sigma;
  table.height_sigma = options.height_sigma;
  table.half_width = options.half_width;
  table.edge_sigma = 0.01;
  return table;
}

std::vector<localization::FreeSphere> hand_spheres(const hand::HandModel& hand,
                                                   const hand::HandReading& reading) {
  const auto T_base_link = hand::forward_kinematics(hand, reading.joints);
  std::vector<localization::FreeSphere> spheres;
  for (const auto& sphere : hand.spheres) {
    spheres.push_back(
        {T_base_link[static_cast<std::size_t>(sphere.link)] * sphere.center, sphere.radius});
  }
  return spheres;
}

void move(const Eigen::Isometry3d& T_new_old, touch::Contact& contact) {
  contact.p = T_new_old * contact.p;
  contact.n = T_new_old.linear() * contact.n;
  contact.f = T_new_old.linear() * contact.f;
}

bool carries(const hand::LinkSphere& sphere, const hand::HandModel& hand, hand::Finger finger) {
  return sphere.link == hand.distal[static_cast<std::size_t>(finger)];
}

/// Where the probing fingertip has been between two readings, without the last `margin` metres.
void add_swept_tip(const hand::HandModel& hand, const TouchLog& log, std::size_t first,
                   std::size_t last, double margin, std::vector<localization::FreeSphere>& swept) {
  const auto T_base_link = hand::forward_kinematics(hand, log.readings[first].joints);
  const Eigen::Vector3d end = log.readings[last].base.xyz;
  Eigen::Vector3d previous = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  for (std::size_t i = first; i <= last; ++i) {
    const auto& base = log.readings[i].base;
    if ((base.xyz - end).norm() < margin) break;
    if ((base.xyz - previous).norm() < kSweptSpacing) continue;
    previous = base.xyz;
    for (const auto& sphere : hand.spheres) {
      if (!carries(sphere, hand, hand::Finger::first)) continue;
      swept.push_back(
          {base.pose() * T_base_link[static_cast<std::size_t>(sphere.link)] * sphere.center,
           sphere.radius});
    }
  }
}

/// Lasting contacts without the error of the links, which all contacts of a finger share.
std::vector<touch::Contact> felt_contacts(std::span<const hand::HandReading> window,
                                          const hand::HandModel& hand,
                                          const touch::ContactErrorModel& errors) {
  auto contacts = touch::lasting_contacts(window, hand, errors);
  for (auto& contact : contacts) {
    const double shared = touch::link_offset_sigma(hand, contact.finger);
    contact.point_sigma = std::sqrt(contact.point_sigma * contact.point_sigma - shared * shared);
  }
  return contacts;
}

/// The links' misplacement displaces all contacts of a finger alike, in the base's axes.
localization::SharedOffset finger_offset(const hand::HandModel& hand, int finger) {
  localization::SharedOffset offset;
  offset.sigma = touch::link_offset_sigma(hand, finger);
  return offset;
}

/// Contacts and free space of the sweeps around the resting object, in the world.
/// @param skipped  sweeps that are left out, the first ones
Evidence evidence_of_sweeps(const hand::HandModel& hand, const TouchLog& log,
                            const LocateOptions& options, std::size_t skipped) {
  Evidence evidence;
  auto offset = finger_offset(hand, static_cast<int>(hand::Finger::first));
  std::size_t sweep = 0, count = 0;
  for (const auto& moment : log.since_release()) {
    if (moment.mark == Mark::sweep) sweep = moment.reading;
    if (moment.mark != Mark::touched && moment.mark != Mark::missed) continue;
    if (count++ < skipped) continue;
    const bool touched = moment.mark == Mark::touched;
    add_swept_tip(hand, log, sweep, moment.reading, touched ? kTouchMargin : 0.0,
                  evidence.free_space);
    if (!touched) continue;
    const Eigen::Isometry3d T_world_base = log.readings[moment.reading].base.pose();
    const auto window = window_before(log, moment.reading, kTouchWindow);
    for (auto contact : felt_contacts(window, hand, options.errors)) {
      move(T_world_base, contact);
      offset.members.push_back({evidence.contacts.size(), T_world_base.linear()});
      evidence.contacts.push_back(contact);
    }
  }
  if (offset.sigma > 0) evidence.offsets.push_back(std::move(offset));
  return evidence;
}

double total_weight(const localization::Posterior& posterior) {
  double sum = 0;
  for (const auto& mode : posterior.modes) sum += mode.weight;
  return sum;
}

/// By how much closing, pressing and lifting move the object in the hand, times `scale`.
Matrix6d motion_covariance(const LocateOptions& options, double scale) {
  const double turn = scale * options.motion_angle_sigma;
  const double way = scale * options.motion_sigma;
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(turn * turn), Eigen::Vector3d::Constant(way * way);
  return variance.asDiagonal();
}

/// Groups contacts by the finger that felt them.
void share_offsets(const hand::HandModel& hand, Evidence& evidence) {
  for (int finger = 0; finger < hand::kFingers; ++finger) {
    auto offset = finger_offset(hand, finger);
    for (std::size_t k = 0; k < evidence.contacts.size(); ++k) {
      if (evidence.contacts[k].finger == finger) offset.members.push_back({k});
    }
    if (offset.sigma > 0 && !offset.members.empty()) evidence.offsets.push_back(std::move(offset));
  }
}

/// Which fingers were at another posture than at the moment of closing.
Fingers moved_fingers(const hand::HandModel& hand, std::span<const hand::HandReading> closed,
                      std::span<const hand::HandReading> probed) {
  const auto T_closed = hand::forward_kinematics(hand, touch::mean_joints(closed));
  const auto T_probed = hand::forward_kinematics(hand, touch::mean_joints(probed));
  Fingers moved{};
  for (std::size_t finger = 0; finger < hand::kFingers; ++finger) {
    const auto link = static_cast<std::size_t>(hand.distal[finger]);
    moved[finger] =
        (T_closed[link] * hand.tips[finger].b - T_probed[link] * hand.tips[finger].b).norm() >
        kElsewhere;
  }
  return moved;
}

/// Adds contacts of some fingers that are carried along with the object to the present.
void add_carried(std::vector<touch::Contact> contacts, const Fingers& fingers,
                 const Eigen::Isometry3d& motion, const LocateOptions& options,
                 Evidence& evidence) {
  for (auto& contact : contacts) {
    if (!fingers[static_cast<std::size_t>(contact.finger)]) continue;
    move(motion, contact);
    contact.point_sigma = std::hypot(contact.point_sigma, options.probe_motion);
    evidence.contacts.push_back(contact);
  }
}

/// The last moment before a probe at which all fingers held the object.
std::size_t holding_before(const TouchLog& log, std::size_t probe) {
  std::size_t latest = log.all(Mark::closed).front();
  for (const Mark mark : {Mark::closed, Mark::held}) {
    for (const std::size_t reading : log.all(mark)) {
      if (reading < probe) latest = std::max(latest, reading);
    }
  }
  return latest;
}

/// Adds what a finger found at another spot while the others held the object: its touch, if it
/// made one, and the space that it takes.
void add_probe(const hand::HandModel& hand, const TouchLog& log, std::size_t probe,
               std::size_t present, const LocateOptions& options, Evidence& evidence) {
  const auto probed = window_before(log, probe, kClosedWindow);
  const auto holding = window_before(log, holding_before(log, probe), kClosedWindow);
  const auto moved = moved_fingers(hand, holding, probed);
  const auto motion = carried_motion(hand, log, probe, present, options.errors, moved);
  add_carried(felt_contacts(probed, hand, options.errors), moved, motion, options, evidence);
  if (!options.free_space) return;
  const auto T_base_link = hand::forward_kinematics(hand, touch::mean_joints(probed));
  for (const auto& sphere : hand.spheres) {
    for (std::size_t finger = 0; finger < hand::kFingers; ++finger) {
      if (!moved[finger] || sphere.link != hand.distal[finger]) continue;
      evidence.free_space.push_back(
          {motion * T_base_link[static_cast<std::size_t>(sphere.link)] * sphere.center,
           sphere.radius});
    }
  }
}

/// Adds what the fingers touched when they had rolled the object aside.
void add_rolled(const hand::HandModel& hand, const TouchLog& log, std::size_t rolled,
                std::size_t present, const LocateOptions& options, Evidence& evidence) {
  Fingers all;
  all.fill(true);
  add_carried(felt_contacts(window_before(log, rolled, kClosedWindow), hand, options.errors), all,
              carried_motion(hand, log, rolled, present, options.errors), options, evidence);
}

/// Share of the peak density that spreads the probability `elsewhere` over all poses.
double floor_density(const PosePrior& prior, double elsewhere) {
  constexpr double kPoses = 8 * std::numbers::pi * std::numbers::pi * 1e-3;  // 1 dm^3, rad^3 m^3
  double peak = 0;
  for (const auto& component : prior.components) {
    const double volume =
        std::sqrt(std::pow(2 * std::numbers::pi, 6) * component.covariance.determinant());
    peak = std::max(peak, component.weight / volume);
  }
  return std::min(0.5, elsewhere / kPoses / peak);
}

/// The resting pose seen from the hand, after a grasp that mostly moved the object a little.
/// @param scale  of that motion
PosePrior prior_after_grasp(const localization::Posterior& resting, const LocateOptions& options,
                            double scale) {
  PosePrior prior;
  double share = 1;
  for (int slides = 0; slides <= kSlides; ++slides) {
    PosePrior part = localization::prior_from(resting, motion_covariance(options, scale));
    const double stays = slides < kSlides ? 1 - options.slide_share : 1;
    for (auto& component : part.components) component.weight *= share * stays;
    prior.components.insert(prior.components.end(), part.components.begin(), part.components.end());
    share *= options.slide_share;
    scale *= kFarther;
  }
  std::stable_sort(prior.components.begin(), prior.components.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  prior.floor = floor_density(prior, options.elsewhere);
  return prior;
}

}  // namespace

void move(const Eigen::Isometry3d& T_new_old, localization::Posterior& posterior) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = T_new_old.linear();
  turn.bottomRightCorner<3, 3>() = T_new_old.linear();
  for (auto& mode : posterior.modes) {
    mode.T_frame_object = T_new_old * mode.T_frame_object;
    mode.covariance = turn * mode.covariance * turn.transpose();
    if (mode.free_axis) {
      mode.free_axis->point = T_new_old * mode.free_axis->point;
      mode.free_axis->direction = T_new_old.linear() * mode.free_axis->direction;
    }
  }
}

localization::Posterior locate_resting(const localization::ObjectModel& object,
                                       const hand::HandModel& hand, const TouchLog& log,
                                       const LocateOptions& options, std::uint64_t seed) {
  if (const auto before = log.before_opening()) {
    return locate(object, hand, *before, options, seed, Mark::placed).posterior;
  }
  const std::size_t sweeps = log.all(Mark::touched).size() + log.all(Mark::missed).size();
  localization::Posterior posterior;
  for (const double forgotten : kForgotten) {
    const auto skipped = static_cast<std::size_t>(forgotten * static_cast<double>(sweeps));
    Evidence evidence = evidence_of_sweeps(hand, log, options, skipped);
    if (evidence.contacts.size() < (skipped > 0 ? kLeastTouches : 1)) break;
    evidence.false_contact_share = options.false_contacts;
    evidence.penetration_sigma = options.swept_sigma;
    evidence.table = resting_table(object.object(), hand, log, options);
    posterior = localization::localize(object, evidence, RandomStream(seed, "locate resting"),
                                       options.search);
    if (total_weight(posterior) > 0) break;
  }
  return posterior;
}

namespace {

constexpr double kForceSigma = 0.02;  // N, of a mean force

/// What the fingertips do to the object that hangs in them, in the hand's base.
localization::ForceBalance balance_of(const std::vector<touch::Contact>& contacts, double mass,
                                      const Eigen::Isometry3d& T_world_base,
                                      const LocateOptions& options) {
  localization::ForceBalance balance;
  for (const auto& contact : contacts) balance.pushes.push_back({contact.p, contact.n, contact.f});
  balance.weight = -kGravity * mass * T_world_base.linear().row(2).transpose();
  balance.force_sigma = kForceSigma;
  balance.twist = options.twist;
  return balance;
}

}  // namespace

PoseEstimate locate(const localization::ObjectModel& object, const hand::HandModel& hand,
                    const TouchLog& log, const LocateOptions& options, std::uint64_t seed,
                    Mark instant) {
  PoseEstimate estimate;
  const auto held = log.at(instant);
  if (!held) return estimate;
  const double window = instant == Mark::held ? options.window : kClosedWindow;

  const auto present = window_before(log, *held, window);
  Evidence evidence;
  evidence.contacts = felt_contacts(present, hand, options.errors);
  evidence.false_contact_share = options.false_contacts;
  evidence.penetration_sigma = options.penetration_sigma;
  if (options.free_space) evidence.free_space = hand_spheres(hand, log.readings[*held]);
  if (options.balance && instant == Mark::held && !evidence.contacts.empty()) {
    evidence.balance = balance_of(evidence.contacts, object.object().mass,
                                  log.readings[*held].base.pose(), options);
  }
  if (const auto closed = log.all(Mark::closed); !closed.empty()) {
    for (const std::size_t probe : log.all(Mark::probed)) {
      add_probe(hand, log, probe, *held, options, evidence);
    }
    for (const std::size_t rolled : log.all(Mark::rolled)) {
      add_rolled(hand, log, rolled, *held, options, evidence);
    }
    auto resting = locate_resting(object, hand, log, options, seed);
    if (total_weight(resting) <= 0) {
      evidence.table = table_at_closing(object.object(), hand, log, options);
    } else {
      const auto motion = carried_motion(hand, log, closed.front(), *held, options.errors);
      move(motion * log.readings[closed.front()].base.pose().inverse(), resting);
      evidence.prior =
          prior_after_grasp(resting, options, log.before_opening() ? kGraspedAnew : 1.0);
    }
  }
  share_offsets(hand, evidence);
  estimate.posterior =
      localization::localize(object, evidence, RandomStream(seed, "locate"), options.search);
  estimate.contacts = evidence.contacts;
  const Eigen::Isometry3d T_world_base = log.readings[*held].base.pose();
  move(T_world_base, estimate.posterior);
  for (auto& contact : estimate.contacts) move(T_world_base, contact);
  return estimate;
}

}  // namespace palpate::pipeline
