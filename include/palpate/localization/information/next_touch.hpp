// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// A touch that could be made: a fingertip, as a ball, comes straight from `start` until it meets
/// the object or has gone `reach`.
struct TouchAction {
  Eigen::Vector3d start;      ///< of the ball's centre, in the posterior's frame, m
  Eigen::Vector3d direction;  ///< unit
  double reach = 0.3;         ///< m
  double seconds = 1;         ///< what it costs
};

/// How a probe is predicted to end.
struct PredictedTouch {
  bool hit = false;
  double distance = 0;  ///< gone by the ball, m
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  ///< of the object there, in the posterior's frame
};

/// Where the ball meets the object at a pose.
PredictedTouch predict_touch(const geometry::ObjectModel& model,
                             const Eigen::Isometry3d& T_frame_object, const TouchAction& probe,
                             double tip_radius);

struct NextTouchOptions {
  double tip_radius = 0.0075;  ///< m
  double point_sigma = 0.002;  ///< of the distance at which contact is sensed, m
  double normal_sigma = 0.25;  ///< of the sensed normal, rad
  int poses = 100;             ///< drawn from the posterior
  int few_poses = 32;          ///< of them on which all probes are compared first
  int finalists = 16;          ///< probes that are compared on all poses

  template <class Visitor>
  void visit(Visitor&& v) {
    v("tip_radius", tip_radius, 0.001, 0.05, "m, radius of the fingertip");
    v("point_sigma", point_sigma, 1e-5, 0.1, "m, error of the distance at which contact is sensed");
    v("normal_sigma", normal_sigma, 1e-3, 10.0, "rad, error of the sensed normal");
    v("poses", poses, 2, 10000, "number of poses drawn from the posterior");
    v("few_poses", few_poses, 2, 10000,
      "number of these poses on which all probes are compared first");
    v("finalists", finalists, 1, 10000, "number of probes that are compared on all poses");
  }
};

/// Lower bound (pairwise, Chernoff) of the information that a probe's outcome s, n holds about
/// which of the poses is true, in nats:
/// -1/M sum_i ln 1/M sum_j exp(-(s_i - s_j)^2 / 8 sp^2 - |n_i - n_j|^2 / 8 sn^2),
/// a miss being alike only to a miss (Kolchinsky & Tracey 2017).
double information_bound(const std::vector<PredictedTouch>& outcomes,
                         const NextTouchOptions& options = {});

/// What several fingertips should sense at once: one touch each, always of the same fingertips.
using PredictedTouches = std::vector<PredictedTouch>;

/// The same bound where an outcome is several touches, whose errors are independent, and the poses
/// have weights: -sum_i w_i ln sum_j w_j exp(-..), at most the weights' entropy.
/// @param weights  of the poses, as many as outcomes; their sum is taken for 1
/// @throws BadInput for other sizes, negative weights or none above 0
double information_bound(const std::vector<PredictedTouches>& outcomes,
                         const std::vector<double>& weights, const NextTouchOptions& options = {});

/// Equally weighted draws from the modes: normal about each, even along a free axis.
std::vector<Eigen::Isometry3d> draw_poses(const Posterior& posterior, int count,
                                          RandomStream& random);

struct TouchChoice {
  std::size_t index = 0;   ///< of the probe
  double information = 0;  ///< bound, nats
};

/// The probe of the greatest bound of information a second.
/// @throws BadInput for no probes, a posterior without modes, or a probe that is not finite
TouchChoice choose_touch(const geometry::ObjectModel& model, const Posterior& posterior,
                         const std::vector<TouchAction>& probes, RandomStream random,
                         const NextTouchOptions& options = {});

}  // namespace palpate::localization
