// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/sweep_choice.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::pipeline {
namespace {

constexpr double kStep = 0.003;       // m of a way between places that are looked at
constexpr double kToldApart = 0.010;  // m between ends that are surely told apart
constexpr double kGuard = 0.002;      // m that the rest of the finger is to stay away

using localization::FreeSphere;

/// Where a sweep ends for the object at one pose.
enum class Ending { touch, nothing, blocked };
struct Outcome {
  Ending ending = Ending::nothing;
  double way = 0;  ///< m
};

bool meets(const localization::ObjectModel& object, const Eigen::Isometry3d& T_object_world,
           const std::vector<FreeSphere>& spheres, const Eigen::Vector3d& at, double margin) {
  return std::any_of(spheres.begin(), spheres.end(), [&](const FreeSphere& sphere) {
    const Eigen::Vector3d p = T_object_world * (at + sphere.center);
    const float distance = object.field().distance(p.cast<float>());
    return distance < object.field().beyond() && distance < sphere.radius + margin;
  });
}

Outcome outcome(const localization::ObjectModel& object, const Eigen::Isometry3d& T_object_world,
                const SweepingFinger& finger, const Sweep& sweep) {
  const double length = (sweep.to - sweep.from).norm();
  for (double way = 0; way <= length; way += kStep) {
    const Eigen::Vector3d at = sweep.from + way / length * (sweep.to - sweep.from);
    if (meets(object, T_object_world, finger.rest, at, kGuard)) return {Ending::blocked, way};
    if (meets(object, T_object_world, finger.tip, at, 0)) return {Ending::touch, way};
  }
  return {Ending::nothing, length};
}

/// A way that ends without a touch of the tip tells only how far the tip came.
double told_apart(const Outcome& a, const Outcome& b) {
  if (a.ending != Ending::touch && b.ending != Ending::touch) return 0;
  return std::min(1.0, std::abs(a.way - b.way) / kToldApart);
}

/// Chance that two draws from the modes are told apart.
double information(const localization::ObjectModel& object,
                   const localization::Posterior& posterior, const SweepingFinger& finger,
                   const Sweep& sweep) {
  std::vector<Outcome> outcomes;
  for (const auto& mode : posterior.modes) {
    outcomes.push_back(outcome(object, mode.T_frame_object.inverse(), finger, sweep));
  }
  double sum = 0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      sum += 2 * posterior.modes[i].weight * posterior.modes[j].weight *
             told_apart(outcomes[i], outcomes[j]);
    }
  }
  return sum;
}

}  // namespace

std::optional<TellingSweep> most_telling_sweep(const localization::ObjectModel& object,
                                               const localization::Posterior& posterior,
                                               const SweepingFinger& finger,
                                               const std::vector<Sweep>& sweeps) {
  std::optional<TellingSweep> best;
  for (const Sweep& sweep : sweeps) {
    const double told = information(object, posterior, finger, sweep);
    if (told > (best ? best->information : 0.0)) best = {sweep, told};
  }
  return best;
}

}  // namespace palpate::pipeline
