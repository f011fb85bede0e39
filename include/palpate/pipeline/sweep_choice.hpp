// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/localization/localizer.hpp"

namespace palpate::pipeline {

/// A straight way of the probing fingertip's centre, world, m.
struct Sweep {
  Eigen::Vector3d from, to;
};

/// The probing finger while it sweeps: balls around its fingertip's centre, in the world's axes.
struct SweepingFinger {
  std::vector<localization::FreeSphere> tip, rest;  ///< rest: of the hand
};

/// A sweep and how well its end tells the modes apart.
struct TellingSweep {
  Sweep sweep;
  double information = 0;  ///< chance, 0..1, that two draws from the modes are told apart
};

/// The one of some sweeps whose end differs most between the modes. Where another part of the hand
/// touches first, the sweep ends, too.
/// @return nothing if there is no sweep that tells anything
std::optional<TellingSweep> most_telling_sweep(const localization::ObjectModel& object,
                                               const localization::Posterior& posterior,
                                               const SweepingFinger& finger,
                                               const std::vector<Sweep>& sweeps);

}  // namespace palpate::pipeline
