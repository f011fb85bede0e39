// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/learning/demonstrations/camera.hpp"
#include "palpate/learning/demonstrations/human_hand.hpp"

namespace palpate::learning {

/// Posture, size and place of a hand: theta, beta and r of thesis eq. 7.6.
struct HandState {
  learning::HumanJoints joints = learning::HumanJoints::Zero();
  learning::HumanShape shape;
  Eigen::Isometry3d T_camera_wrist = Eigen::Isometry3d::Identity();

  learning::HandKeypoints keypoints() const {
    return learning::human_keypoints(joints, shape, T_camera_wrist);
  }
};

/// Depth along the camera's z (m) of every pixel, height x width; 0 where there is nothing.
using DepthImage = Eigen::MatrixXd;

/// R(theta, beta, r) of thesis eq. 7.7: the hand's capsules as the camera sees them.
DepthImage render_depth(const PinholeCamera& camera, const HandState& state);

/// Depth of one pixel, m; 0 if the hand is not there.
double depth_at(const PinholeCamera& camera, const learning::HandKeypoints& keypoints,
                const learning::HumanShape& shape, const Eigen::Vector2d& pixel);

struct HandFitOptions {
  double lambda = 0.001;      ///< weight of the depth, mm^2, against the keypoints, pixel^2
  int stride = 6;             ///< every n-th masked pixel of each row and column is compared
  double largest_gap = 0.04;  ///< m, at which a wrong depth is cut off
  double rest = 0.05;         ///< weight of a joint's squared distance from its range's middle
  double size = 20;           ///< weight of a squared change of size
  bool fit_shape = true;
  int iterations = 60;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("lambda", lambda, 0.0, 1e3,
      "mm^2, weight of the depth against that of the keypoints in pixel^2");
    v("stride", stride, 1, 1000, "use every n-th pixel of the mask");
    v("largest_gap", largest_gap, 1e-4, 10.0,
      "m, difference of depths above which a pixel counts as wrong");
    v("rest", rest, 0.0, 1e6, "weight of a joint's distance from the middle of its range");
    v("size", size, 0.0, 1e6, "weight of a change of the hand's size");
    v("fit_shape", fit_shape, "estimate the hand's size, too");
    v("iterations", iterations, 1, 100000, "iterations at most");
  }
};

/// What a camera measures of a hand.
struct HandImage {
  Eigen::Matrix<double, 2, learning::kHandKeypoints> pixels;  ///< NaN for a joint that is not seen
  DepthImage depth;  ///< m, height x width; empty: keypoints alone
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> mask;  ///< the hand's pixels; as the depth
};

enum class HandFitStatus { ok, too_few_keypoints };

struct HandFit {
  HandFitStatus status = HandFitStatus::ok;
  HandState state;
  double pixel_rms = 0;  ///< of the keypoints
  double depth_rms = 0;  ///< m, of the compared pixels
  int iterations = 0;
};

/// Where the hand is as far as depth alone determines it: the center of the masked depth.
/// @return none if no masked pixel has a depth
std::optional<Eigen::Vector3d> masked_center(const PinholeCamera& camera, const HandImage& image);

/// Fits the hand to 2-D keypoints and masked depth (thesis eq. 7.7), from a state near by.
/// @throws BadInput if depth and mask have other sizes than the camera's image
HandFit fit_hand(const PinholeCamera& camera, const HandImage& image, const HandState& start,
                 const HandFitOptions& options = {});

/// Fits the hand to points in space: column i is where keypoint i shall be, NaN for anywhere.
/// @return the state; pixel_rms is the distance's in mm
HandFit fit_hand(const learning::HandKeypoints& targets, const HandState& start,
                 const HandFitOptions& options = {});

}  // namespace palpate::learning
