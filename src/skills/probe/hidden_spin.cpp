// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/hidden_spin.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace palpate::skills {
namespace {

constexpr double kShows = 3;  // times the error of the surface

/// Root mean square distance of the moved surface from the original, m.
double surface_change(const geometry::ObjectModel& object, const Eigen::Isometry3f& motion) {
  float sum = 0;
  for (const auto& at : object.surface()) {
    const float apart = object.field().distance(motion * at.p);
    sum += apart * apart;
  }
  return std::sqrt(sum / static_cast<float>(object.surface().size()));
}

bool spin_is_hidden(const geometry::ObjectModel& object, const localization::Mode& mode,
                    double surface_sigma) {
  const localization::FreeAxis& axis = *mode.free_axis;
  const Eigen::Isometry3d T_object_frame = mode.T_frame_object.inverse();
  const Eigen::Vector3d point = T_object_frame * axis.point;
  const Eigen::Vector3d direction = T_object_frame.linear() * axis.direction;
  double change = 0;
  for (const double share : {-1.0, -0.5, 0.5, 1.0}) {
    const Eigen::Isometry3d spin = Eigen::Translation3d(point) *
                                   Eigen::AngleAxisd(share * axis.extent, direction) *
                                   Eigen::Translation3d(-point);
    change = std::max(change, surface_change(object, spin.cast<float>()));
  }
  return change < kShows * surface_sigma;
}

}  // namespace

double probability_but_for_hidden_spin(const geometry::ObjectModel& object,
                                       const localization::Posterior& posterior,
                                       double surface_sigma) {
  if (posterior.modes.empty()) return 0;
  const localization::Mode& best = posterior.modes.front();
  return best.free_axis && spin_is_hidden(object, best, surface_sigma) ? best.weight
                                                                       : pose_probability(best);
}

}  // namespace palpate::skills
