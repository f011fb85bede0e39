// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/extents.hpp"

#include <algorithm>
#include <utility>

namespace palpate::skills {
namespace {

constexpr double kTooHigh = 0.01;    // m that the probed height may be over the object's
constexpr double kClearOver = 0.03;  // m of the hand over what may stand
constexpr double kTooLow = 0.06;     // m that it may be under it, amply: hands have gaps

double reach_of(const geometry::KnownObject& object, const geometry::StablePose& stable_pose) {
  double reach = 0;
  for (const auto& vertex : object.mesh.vertices) {
    reach = std::max(reach, (stable_pose.R_table_object * vertex).head<2>().norm());
  }
  return reach;
}

/// In the stable poses that are as tall as was measured; in any where none is.
double reach_of(const geometry::KnownObject& object, double measured) {
  double reach = 0, reach_of_any = 0;
  for (const auto& stable_pose : object.stable_poses) {
    const double far = reach_of(object, stable_pose);
    reach_of_any = std::max(reach_of_any, far);
    if (geometry::top_of(object, stable_pose) > measured - kTooLow) reach = std::max(reach, far);
  }
  return reach > 0 ? reach : reach_of_any;
}

}  // namespace

double tallest(const estimation::Candidates& candidates) {
  double top = 0;
  for (const auto* candidate : candidates) {
    for (const auto& stable_pose : candidate->object().stable_poses) {
      top = std::max(top, geometry::top_of(candidate->object(), stable_pose));
    }
  }
  return top;
}

double clear_height_over(const estimation::Candidates& candidates) {
  return tallest(candidates) + kClearOver;
}

double likely_top(const estimation::Candidates& candidates, double measured) {
  double likely = measured;
  for (const auto* candidate : candidates) {
    for (const auto& stable_pose : candidate->object().stable_poses) {
      const double top = geometry::top_of(candidate->object(), stable_pose);
      if (top > measured - kTooHigh && top < measured + kTooLow) likely = std::max(likely, top);
    }
  }
  return likely;
}

double likely_reach(const estimation::Candidates& candidates, double measured) {
  double reach = 0;
  for (const auto* candidate : candidates) {
    reach = std::max(reach, reach_of(candidate->object(), measured));
  }
  return reach;
}

std::vector<localization::PosedObject> possible_objects(
    const estimation::PoseEstimator& estimator) {
  std::vector<localization::PosedObject> objects;
  auto posteriors = estimator.posteriors();
  for (std::size_t i = 0; i < posteriors.size(); ++i) {
    objects.push_back({estimator.candidates()[i], std::move(posteriors[i])});
  }
  return objects;
}

double mass_elsewhere(const std::vector<localization::PosedObject>& objects) {
  double elsewhere = 1;
  for (const auto& [object, posterior] : objects) {
    for (const localization::Mode& mode : posterior.modes) elsewhere -= mode.weight;
  }
  return elsewhere;
}

double highest_of(const std::vector<localization::PosedObject>& objects) {
  double top = 0;
  for (const auto& [object, posterior] : objects) {
    for (const auto& mode : posterior.modes) {
      const Eigen::RowVector3d up = mode.T_frame_object.linear().row(2);
      for (const auto& vertex : object->object().mesh.vertices) {
        top = std::max(top, mode.T_frame_object.translation().z() + up.dot(vertex));
      }
    }
  }
  return top;
}

}  // namespace palpate::skills
