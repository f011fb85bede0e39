// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string_view>

#include "palpate/hand/shadow.hpp"

namespace palpate::learning {

inline constexpr int kHumanJoints = 25;
/// Order of the human hand's joint vectors (thesis figures 2.1(b) and A.1), numbered from the tip
/// to the base: two of the wrist, five of the thumb, four of each finger, and the carpal joints of
/// ring and little finger that hollow the palm.
inline constexpr std::array<std::string_view, kHumanJoints> kHumanJointNames = {
    "WR2", "WR1", "TH5", "TH4", "TH3", "TH2", "TH1", "FF4", "FF3", "FF2", "FF1", "MF4", "MF3",
    "MF2", "MF1", "RF5", "RF4", "RF3", "RF2", "RF1", "LF5", "LF4", "LF3", "LF2", "LF1"};

using HumanJoints = Eigen::Matrix<double, kHumanJoints, 1>;  ///< rad

/// Ranges of motion: thesis table A.2, and what it leaves out. Of the sums TH2+TH3 and TH4+TH5 each
/// joint has the whole range.
const std::array<hand::Range, kHumanJoints>& human_ranges();

/// @throws BadInput for a name that is not in kHumanJointNames
int human_joint_index(std::string_view name);

inline constexpr int kHandKeypoints = 21;
/// Joints of a hand as a camera's detectors name them, m: wrist; then of thumb, first, middle, ring
/// and little finger each the three joints from the palm outwards and the tip.
using HandKeypoints = Eigen::Matrix<double, 3, kHandKeypoints>;

/// Column of HandKeypoints. @param along  0 the joint in the palm .. 3 the tip
constexpr int keypoint(hand::FingerName finger, int along) {
  return 1 + 4 * static_cast<int>(finger) + along;
}

/// Size of a hand (beta of thesis eq. 7.6), as factors of the mean hand's lengths.
struct HumanShape {
  double palm = 1;
  std::array<double, hand::kShadowFingers> fingers = {1, 1, 1, 1, 1};
};

/// Keypoints J(theta, beta, r) of a right hand (thesis eq. 7.6).
/// @param T_world_wrist  of the forearm's end: z to the fingers, x to the thumb's side, the palm
///                       faces -y
HandKeypoints human_keypoints(const HumanJoints& joints, const HumanShape& shape,
                              const Eigen::Isometry3d& T_world_wrist);

/// A part of the hand as a capsule between two keypoints.
struct HumanBone {
  int from, to;   ///< keypoints
  double radius;  ///< m, of the mean hand
};

/// All parts of the hand: five rays of the palm, and three bones of each finger.
const std::array<HumanBone, 20>& human_bones();

/// Frame of a hand from its keypoints: z from the wrist to the middle finger's knuckle, x to the
/// first finger's side, the palm faces -y. @throws BadInput if the knuckles lie on one line
Eigen::Matrix3d palm_frame(const Eigen::Vector3d& wrist, const Eigen::Vector3d& first_knuckle,
                           const Eigen::Vector3d& middle_knuckle,
                           const Eigen::Vector3d& little_knuckle);
Eigen::Matrix3d palm_frame(const HandKeypoints& keypoints);

}  // namespace palpate::learning
