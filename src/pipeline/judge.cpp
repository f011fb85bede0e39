// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/judge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::pipeline {
namespace {

constexpr double kLifted = 0.05;                           // m above the table
constexpr double kMostSlip = 0.010;                        // m
constexpr double kPoseAngle = 5 * std::numbers::pi / 180;  // rad
constexpr double kPoseDistance = 0.010;                    // m

}  // namespace

void Judge::observe(const hand::HandReading& reading) {
  const simulation::Truth truth = world_.truth();
  moments_.push_back({reading.base.pose().inverse() * truth.T_world_object, truth.lowest_point});
}

Judgement Judge::verdict(const PickResult& result, const TouchLog& log, const LiftOptions& lift,
                         const std::vector<Eigen::Matrix3d>& symmetries) const {
  Judgement judgement;
  judgement.T_world_object = world_.truth().T_world_object;
  if (const auto held = log.at(Mark::held); held && !world_.diverged()) {
    const auto hold = static_cast<std::size_t>(std::lround(lift.hold / hand::kTick));
    const std::size_t first = *held - std::min(*held, hold);
    const auto& before = moments_[first].T_base_object.translation();
    double lowest = moments_[first].lowest_point;
    for (std::size_t i = first; i <= *held; ++i) {
      judgement.slip =
          std::max(judgement.slip, (moments_[i].T_base_object.translation() - before).norm());
      lowest = std::min(lowest, moments_[i].lowest_point);
    }
    judgement.lifted = lowest > kLifted && judgement.slip < kMostSlip;
  }
  const auto& posterior = result.estimate.posterior;
  judgement.has_pose = !posterior.modes.empty();
  if (judgement.has_pose) {
    const auto& truth = judgement.T_world_object;
    const auto& best = posterior.modes[0].T_frame_object;
    judgement.error = localization::pose_error(best, truth, symmetries);
    judgement.error_no_symmetry =
        localization::pose_error(best, truth, {Eigen::Matrix3d::Identity()});
    judgement.pose_ok =
        judgement.error.rotation < kPoseAngle && judgement.error.translation < kPoseDistance;
    judgement.truth_in_modes = localization::truth_in_modes(posterior, truth, symmetries);
  }
  return judgement;
}

}  // namespace palpate::pipeline
