// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "palpate/hand/point_kinematics.hpp"
#include "palpate/learning/demonstrations/human_hand.hpp"

namespace palpate::learning {

/// Where on a robot's hand the human's points are: names of sites, or of bodies for their origins.
struct RetargetPoints {
  std::array<std::string, hand::kShadowFingers> tips, middles;  ///< thumb .. little finger
  std::array<std::string, 3> knuckles;                          ///< first, middle, little finger
};

/// Those of the Adroit hand, whose root is the body "palm".
RetargetPoints adroit_points();

struct RetargetOptions {
  double alpha = 8e-3;        ///< weight of a joint's change since the frame before, m^2/rad^2
  double scale = 0;           ///< of the human's hand; 0: the ratio of the palms' sizes
  double largest_step = 0.3;  ///< of a joint from frame to frame, rad
  int evaluations = 40;       ///< of the objective in a frame, at most
  double tolerance = 1e-4;    ///< relative, of the objective

  template <class Visitor>
  void visit(Visitor&& v) {
    v("alpha", alpha, 0.0, 1e3, "m^2/rad^2, weight of a joint's change since the previous frame");
    v("scale", scale, 0.0, 10.0,
      "size of the human's hand relative to the robot's; 0: the ratio of the palms");
    v("largest_step", largest_step, 1e-3, 10.0,
      "rad, largest change of a joint between two frames");
    v("evaluations", evaluations, 1, 100000, "evaluations of the objective per frame at most");
    v("tolerance", tolerance, 0.0, 1.0,
      "relative change of the objective at which the minimisation ends");
  }
};

struct RetargetedFrame {
  Eigen::VectorXd joints;  ///< of the robot's hand, rad
  /// Of its root; the world is the keypoints' frame. The two hands' tips have the same center.
  Eigen::Isometry3d T_world_root;
  double tip_error = 0;     ///< mean distance of the tips from the scaled human's, m
  double middle_error = 0;  ///< of the middle joints, m
};

/// Carries a human hand's motion over to a robot's, frame by frame: the vectors from the hand's
/// root to the five tips and middle joints shall agree (thesis eq. 7.8, solved by SLSQP).
/// The root turns freely. How far it lies from the human's wrist is found in the first frame.
class Retargeter {
 public:
  /// @throws BadInput for a point that the hand lacks, or a tip that is not near its link's end
  Retargeter(std::unique_ptr<hand::PointKinematics> hand, const RetargetPoints& points,
             const RetargetOptions& options = {});

  /// The next frame of a motion. In the first one nothing holds the joints where they were.
  /// @throws BadInput for keypoints that are not finite
  RetargetedFrame next(const learning::HandKeypoints& human);

  /// Forgets the motion so far.
  void restart() { started_ = false; }

  const hand::PointKinematics& hand() const { return *hand_; }

 private:
  struct Problem;
  void solve(const learning::HandKeypoints& human, double alpha, double largest_step);
  void start(const learning::HandKeypoints& human);

  std::unique_ptr<hand::PointKinematics> hand_;
  RetargetOptions options_;
  std::vector<hand::HandPoint> points_;  // tips, then middle joints
  std::vector<hand::HandPoint> knuckles_;
  Eigen::Matrix3d R_root_palm_;  // of the frame that the knuckles span
  double palm_length_ = 0;
  double scale_ = 1;
  bool started_ = false;
  Eigen::VectorXd state_;  // joints, then the root's turn against the human's palm
};

}  // namespace palpate::learning
