// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// An estimate as it is recorded: its modes, not its residual set.
/// @param time  s, of the instant that it is of
EstimateRecord estimate_record(double time, const estimation::HeldPoseEstimate& estimate);

/// The status and the modes of a recorded estimate.
/// @throws BadInput for a status of another name
localization::Posterior posterior_of(const EstimateRecord& record);

}  // namespace palpate::recording
