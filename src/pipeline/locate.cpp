// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/locate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "palpate/pipeline/feel_phase.hpp"

namespace palpate::pipeline {
namespace {

using geometry::KnownObject;
using localization::Evidence;
using localization::TableSupport;

std::span<const hand::HandReading> window_before(const TouchLog& log, std::size_t index,
                                                 double seconds) {
  const auto count =
      std::min(index + 1, static_cast<std::size_t>(std::ceil(seconds / hand::kTick)));
  return std::span(log.readings).subspan(index + 1 - count, count);
}

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

TableSupport table_at_closing(const KnownObject& object, const hand::HandModel& hand,
                              const TouchLog& log, const LocateOptions& options) {
  TableSupport table;
  const auto& closed = log.readings[*log.at(Mark::closed)];
  table.T_frame_table = closed.base.pose().inverse();
  std::optional<double> felt;
  if (const auto at = log.at(Mark::felt)) felt = lowest_of_hand(hand, log.readings[*at]);
  table.stance_weights = stance_weights(object, felt, options);
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

void move_to_world(const Eigen::Isometry3d& T_world_base, PoseEstimate& estimate) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = T_world_base.linear();
  turn.bottomRightCorner<3, 3>() = T_world_base.linear();
  for (auto& mode : estimate.posterior.modes) {
    mode.T_frame_object = T_world_base * mode.T_frame_object;
    mode.covariance = turn * mode.covariance * turn.transpose();
    if (mode.free_axis) {
      mode.free_axis->point = T_world_base * mode.free_axis->point;
      mode.free_axis->direction = T_world_base.linear() * mode.free_axis->direction;
    }
  }
  for (auto& contact : estimate.contacts) {
    contact.p = T_world_base * contact.p;
    contact.n = T_world_base.linear() * contact.n;
    contact.f = T_world_base.linear() * contact.f;
  }
}

}  // namespace

PoseEstimate locate(const localization::ObjectModel& object, const hand::HandModel& hand,
                    const TouchLog& log, const LocateOptions& options, std::uint64_t seed) {
  PoseEstimate estimate;
  const auto held = log.at(Mark::held);
  if (!held) return estimate;

  Evidence evidence;
  evidence.contacts =
      touch::lasting_contacts(window_before(log, *held, options.window), hand, options.errors);
  evidence.false_contact_share = options.false_contacts;
  evidence.penetration_sigma = options.penetration_sigma;
  if (options.free_space) evidence.free_space = hand_spheres(hand, log.readings[*held]);
  if (log.at(Mark::closed)) {
    evidence.table = table_at_closing(object.object(), hand, log, options);
  }
  estimate.posterior =
      localization::localize(object, evidence, RandomStream(seed, "locate"), options.search);
  estimate.contacts = evidence.contacts;
  move_to_world(log.readings[*held].base.pose(), estimate);
  return estimate;
}

}  // namespace palpate::pipeline
