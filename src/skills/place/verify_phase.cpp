// SPDX-License-Identifier: Apache-2.0
#include "skills/place/verify_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/height_likelihood.hpp"

namespace palpate::skills {
namespace {

constexpr double kWrongHeight = 0.015;  // m: measured that far from what was expected, it fell over

double top_of(const geometry::TriangleMesh& mesh, const Eigen::Isometry3d& T) {
  double top = -std::numeric_limits<double>::infinity();
  for (const auto& v : mesh.vertices) top = std::max(top, (T * v).z());
  return top;
}

}  // namespace

PhaseEnd VerifyPhase::run(Executor& robot, PickState& state) {
  const double top = top_of(object_.mesh, T_world_object_);
  const PhaseEnd probed = HeightProbePhase(options_, top).run(robot, state);
  const double expected =
      estimation::stopping_height(object_, T_world_object_, robot.model(), robot.reading());
  if (!probed.ok && expected < options_.clearance) return {true, "it fits between the fingers"};
  if (!probed.ok) return {false, "found nothing where the object was put"};
  const double off = state.height - expected;
  return {std::abs(off) < kWrongHeight,
          fmt::format("the hand was stopped {:.1f} mm {} where the object should stop it",
                      1e3 * std::abs(off), off < 0 ? "below" : "above")};
}

}  // namespace palpate::skills
