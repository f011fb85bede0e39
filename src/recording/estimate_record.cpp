// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/estimate_record.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"

namespace palpate::recording {
namespace {

using localization::PoseStatus;

PoseModeRecord mode_record(const localization::Mode& mode) {
  PoseModeRecord record{mode.T_frame_object, mode.weight, mode.covariance, {}};
  if (mode.free_axis) {
    const auto& axis = *mode.free_axis;
    record.free_axis = {axis.point, axis.direction, axis.extent, axis.share};
  }
  return record;
}

PoseStatus status_of(const std::string& name) {
  for (const auto status : {PoseStatus::certain, PoseStatus::ambiguous, PoseStatus::no_pose}) {
    if (localization::to_string(status) == name) return status;
  }
  throw BadInput(fmt::format("the recording has an estimate of status {:?}", name));
}

}  // namespace

EstimateRecord estimate_record(double time, const estimation::HeldPoseEstimate& estimate) {
  EstimateRecord record;
  record.time = time;
  record.status = localization::to_string(estimate.posterior.status);
  for (const auto& mode : estimate.posterior.modes) record.modes.push_back(mode_record(mode));
  record.contacts = estimate.contacts;
  return record;
}

localization::Posterior posterior_of(const EstimateRecord& record) {
  localization::Posterior posterior;
  posterior.status = status_of(record.status);
  for (const auto& one : record.modes) {
    localization::Mode mode{one.T_world_object, one.weight, one.covariance, {}};
    if (one.free_axis) {
      const auto& axis = *one.free_axis;
      mode.free_axis = {axis.point, axis.direction, axis.extent, axis.share};
    }
    posterior.modes.push_back(mode);
  }
  return posterior;
}

}  // namespace palpate::recording
