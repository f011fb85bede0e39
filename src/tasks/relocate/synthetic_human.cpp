// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/synthetic_human.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/hand/shadow.hpp"
#include "palpate/learning/demonstrations/minimum_jerk.hpp"

namespace palpate::relocate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using hand::FingerName;
using learning::HandKeypoints;

constexpr double kPad = 0.008;     // m, from the tip's keypoint to the skin that touches
constexpr double kOverlap = 0.04;  // s by which the parts of a motion overlap at either end
constexpr double kOpening = 0.35;  // share of the grasp's flexion with which the hand approaches

constexpr double kRise = 0.045, kBack = 0.02;  // m, of the hand before it descends
const Vector3d kWristAtStart(0, -0.22, 0.20);  // m

/// Palm down, fingers along +y: the hand's axes x, y, z are the world's -x, z, y.
Eigen::Matrix3d palm_down() {
  Eigen::Matrix3d R;
  R << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  return R;
}

/// The wrist's axes in the grasp.
Eigen::Matrix3d turned(const SyntheticGrasp& grasp) {
  return (Eigen::AngleAxisd(grasp.yaw, Vector3d::UnitZ()) *
          Eigen::AngleAxisd(-grasp.pitch, Vector3d::UnitX()) *
          Eigen::AngleAxisd(-grasp.roll, Vector3d::UnitY()))
             .toRotationMatrix() *
         palm_down();
}

/// Degrees from +x about the object's axis at which a tip touches; from the first finger to the
/// little one they go clockwise.
double around(const SyntheticGrasp& grasp, std::size_t finger) {
  if (finger == 0) return grasp.thumb;
  return grasp.fingers + grasp.apart * (2.5 - static_cast<double>(finger));
}

HandKeypoints nowhere() {
  return HandKeypoints::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// The grasp's joints with the fingers opened.
learning::HumanJoints opened(const learning::HumanJoints& grasp) {
  learning::HumanJoints q = kOpening * grasp;
  q.head<2>() = grasp.head<2>();
  for (const char* joint : {"FF4", "MF4", "RF4", "LF4", "TH4"}) {
    q[learning::human_joint_index(joint)] = grasp[learning::human_joint_index(joint)];
  }
  return q;
}

/// One part of a motion: from `begin` to `end` (s), a little before and after included.
double share_of_part(double time, double begin, double end) {
  return learning::minimum_jerk_share((time - begin + kOverlap) / (end - begin + 2 * kOverlap));
}

struct Schedule {
  double over, down, closed, there, end;  ///< s
};

Schedule schedule(const SyntheticHumanOptions& o, RandomStream& random) {
  const auto varied = [&](double time) {
    return time * std::exp(o.tempo_spread * std::clamp(random.normal(), -2.0, 2.0));
  };
  Schedule s{};
  s.over = varied(o.reach);
  s.down = s.over + varied(o.descend);
  s.closed = s.down + varied(o.close);
  s.there = s.closed + varied(o.carry);
  s.end = s.there + o.hold;
  return s;
}

learning::HumanShape varied_shape(double spread, RandomStream& random) {
  learning::HumanShape shape;
  const double size = 1 + spread * std::clamp(random.normal(), -2.0, 2.0);
  shape.palm = size;
  for (double& finger : shape.fingers) {
    finger = size * (1 + spread / 2 * std::clamp(random.normal(), -2.0, 2.0));
  }
  return shape;
}

/// What a detector makes of the keypoints.
HandKeypoints seen(HandKeypoints keypoints, const SyntheticHumanOptions& o, RandomStream& random) {
  for (Eigen::Index i = 0; i < keypoints.cols(); ++i) {
    keypoints.col(i) += o.noise * random.normal3();
    if (random.uniform() < o.missing) {
      keypoints.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return keypoints;
}

}  // namespace

learning::HandState synthetic_grasp(const Vector3d& object, const learning::HumanShape& shape,
                                    const SyntheticHumanOptions& options, RandomStream& random) {
  const SyntheticGrasp& grasp = options.grasp;
  HandKeypoints targets = nowhere();
  for (std::size_t i = 0; i < hand::kShadowFingers; ++i) {
    const double angle = around(grasp, i) * std::numbers::pi / 180;
    const double radius = options.grip_radius + kPad;
    const Vector3d tip(radius * std::cos(angle), radius * std::sin(angle),
                       i == 0 ? grasp.thumb_height : grasp.finger_height);
    targets.col(learning::keypoint(static_cast<FingerName>(i), 3)) =
        object + tip + options.place_spread * random.normal3();
  }
  learning::HandState start;
  start.shape = shape;
  for (const char* joint : {"FF3", "MF3", "RF3", "LF3", "FF2", "MF2", "RF2", "LF2"}) {
    start.joints[learning::human_joint_index(joint)] = 0.6;
  }
  start.T_camera_wrist.linear() = turned(grasp);
  start.T_camera_wrist.translation() =
      object + Vector3d(grasp.wrist_x, grasp.wrist_y, grasp.wrist_z);
  targets.col(0) = start.T_camera_wrist.translation();
  learning::HandFitOptions fit;
  fit.fit_shape = false;
  fit.rest = 5;
  return learning::fit_hand(targets, start, fit).state;
}

learning::HumanSequence synthetic_relocation(const Vector3d& object, const Vector3d& target,
                                             const SyntheticHumanOptions& options,
                                             RandomStream& random) {
  const Schedule s = schedule(options, random);
  const auto shape = varied_shape(options.size_spread, random);
  const learning::HandState grasp = synthetic_grasp(object, shape, options, random);
  const learning::HumanJoints open = opened(grasp.joints);
  const Vector3d in_grasp = grasp.T_camera_wrist.translation();
  const Vector3d above = in_grasp + Vector3d(0, -kBack, kRise);
  const Eigen::Quaterniond at_start(palm_down()), in_hand(grasp.T_camera_wrist.linear());
  learning::HumanSequence sequence;
  sequence.rate = options.rate;
  const int frames = static_cast<int>(s.end * options.rate) + 1;
  for (int i = 0; i < frames; ++i) {
    const double t = i / options.rate;
    const double carried = share_of_part(t, s.closed + kOverlap, s.there);
    learning::HandState now = grasp;
    now.joints = open + share_of_part(t, s.down, s.closed - kOverlap) * (grasp.joints - open);
    const double reached = learning::minimum_jerk_share(t / (s.over + kOverlap));
    now.T_camera_wrist.linear() = at_start.slerp(reached, in_hand).toRotationMatrix();
    now.T_camera_wrist.translation() = kWristAtStart + reached * (above - kWristAtStart) +
                                       share_of_part(t, s.over, s.down) * (in_grasp - above) +
                                       carried * (target - object);
    sequence.hand.push_back(seen(now.keypoints(), options, random));
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = object + carried * (target - object);
    sequence.T_hand_object.push_back(pose);
  }
  return sequence;
}

}  // namespace palpate::relocate
