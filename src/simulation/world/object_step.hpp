// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/simulation/world/object_step.hpp"
#include "simulation/world/scene.hpp"

namespace palpate::simulation {

/// What a step changes, at its start.
struct StepStart {
  Eigen::Vector3d momentum;  ///< of the object, linear, kg m/s
  hand::JointVector joints;  ///< rad
};

StepStart read_step_start(const Scene& scene, const mjData& data);

/// The step of which `data` is the end.
ObjectStep read_object_step(const Scene& scene, const mjData& data, const StepStart& start);

}  // namespace palpate::simulation
