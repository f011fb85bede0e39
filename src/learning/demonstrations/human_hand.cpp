// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/human_hand.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::learning {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

/// Lengths of the mean hand, m: knuckles from the wrist, and the three bones of each finger.
struct Ray {
  Vector3d knuckle;
  std::array<double, 3> bones;
};
const std::array<Ray, 4>& rays() {
  static const std::array<Ray, 4> values = {{{{0.026, 0, 0.086}, {0.038, 0.024, 0.024}},
                                             {{0.003, 0, 0.092}, {0.041, 0.026, 0.025}},
                                             {{-0.020, 0, 0.084}, {0.037, 0.026, 0.025}},
                                             {{-0.038, 0, 0.074}, {0.029, 0.020, 0.021}}}};
  return values;
}
constexpr double kCarpals = 0.02;  // m from the wrist, where ring and little finger's rays bend

const Vector3d kThumbBase(0.024, -0.010, 0.024);
constexpr std::array<double, 3> kThumb = {0.042, 0.031, 0.029};
constexpr double kThumbSplay = 1.1;  // rad, of the thumb's ray from the fingers, at rest
constexpr double kThumbTurn = -0.8;  // rad, of its nail to the side

AngleAxisd about_x(double angle) { return {angle, Vector3d::UnitX()}; }
AngleAxisd about_y(double angle) { return {angle, Vector3d::UnitY()}; }
AngleAxisd about_z(double angle) { return {angle, Vector3d::UnitZ()}; }

/// Three bones in a row that flex about x, written as keypoints `first` to `first` + 3.
void place_bones(HandKeypoints& points, int first, Isometry3d T,
                 const std::array<double, 3>& lengths, const std::array<double, 3>& flexion) {
  points.col(first) = T.translation();
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    T = T * about_x(flexion[i]) * Translation3d(0, 0, lengths[i]);
    points.col(first + 1 + static_cast<int>(i)) = T.translation();
  }
}

std::array<double, 3> scaled(std::array<double, 3> lengths, double factor) {
  for (double& length : lengths) length *= factor;
  return lengths;
}

void place_thumb(HandKeypoints& points, const HumanJoints& q, const HumanShape& shape,
                 const Isometry3d& T_world_palm) {
  const Isometry3d T = T_world_palm * Translation3d(shape.palm * kThumbBase) *
                       about_y(kThumbSplay) * about_z(kThumbTurn) * about_y(-q[2]);
  // The knuckle bends to the side (TH3) before it flexes (TH2).
  points.col(keypoint(hand::FingerName::thumb, 0)) = T.translation();
  const auto lengths = scaled(kThumb, shape.fingers[0]);
  const Isometry3d knuckle = T * about_x(q[3]) * Translation3d(0, 0, lengths[0]) * about_y(-q[4]);
  HandKeypoints outer;
  place_bones(outer, 0, knuckle, {lengths[1], lengths[2], 0}, {q[5], q[6], 0});
  points.middleCols<3>(keypoint(hand::FingerName::thumb, 1)) = outer.leftCols<3>();
}

void place_finger(HandKeypoints& points, hand::FingerName finger, const HumanJoints& q,
                  const HumanShape& shape, const Isometry3d& T_world_palm) {
  constexpr std::array<int, 4> kFirstJoint = {7, 11, 16, 21};  // J4 of each
  const int index = static_cast<int>(finger);
  const auto ray = static_cast<std::size_t>(index - 1);
  const int j4 = kFirstJoint[ray];
  const bool carpal = finger == hand::FingerName::ring || finger == hand::FingerName::little;
  const Vector3d hollow(0, 0, kCarpals);
  const Isometry3d T = T_world_palm * Translation3d(shape.palm * hollow) *
                       about_x(carpal ? q[j4 - 1] : 0) *
                       Translation3d(shape.palm * (rays()[ray].knuckle - hollow)) * about_y(q[j4]);
  place_bones(points, keypoint(finger, 0), T,
              scaled(rays()[ray].bones, shape.fingers[static_cast<std::size_t>(index)]),
              {q[j4 + 1], q[j4 + 2], q[j4 + 3]});
}

hand::Range table_range(std::string_view joints) {
  const auto* const found =
      std::find_if(hand::kHumanRanges.begin(), hand::kHumanRanges.end(),
                   [&](const hand::HumanRange& range) { return range.joints == joints; });
  return found->range;
}

std::array<hand::Range, kHumanJoints> make_ranges() {
  constexpr hand::Range kSideways = {-0.349, 0.349}, kHollow = {0, 0.524};
  const hand::Range knuckle = table_range("FF3 MF3 RF3 LF3");
  const hand::Range proximal = table_range("FF2 MF2 RF2 LF2"),
                    distal = table_range("FF1 MF1 RF1 LF1");
  const hand::Range carpal = table_range("TH4+TH5"), thumb = table_range("TH2+TH3");
  return {table_range("WR2"),
          table_range("WR1"),
          carpal,
          carpal,
          thumb,
          thumb,
          table_range("TH1"),
          kSideways,
          knuckle,
          proximal,
          distal,  // FF
          kSideways,
          knuckle,
          proximal,
          distal,  // MF
          kHollow,
          kSideways,
          knuckle,
          proximal,
          distal,  // RF
          kHollow,
          kSideways,
          knuckle,
          proximal,
          distal};
}

}  // namespace

const std::array<hand::Range, kHumanJoints>& human_ranges() {
  static const auto ranges = make_ranges();
  return ranges;
}

int human_joint_index(std::string_view name) {
  const auto* const found = std::find(kHumanJointNames.begin(), kHumanJointNames.end(), name);
  if (found == kHumanJointNames.end()) {
    throw BadInput(fmt::format("the human hand has no joint '{}'", name));
  }
  return static_cast<int>(found - kHumanJointNames.begin());
}

HandKeypoints human_keypoints(const HumanJoints& joints, const HumanShape& shape,
                              const Isometry3d& T_world_wrist) {
  HandKeypoints points;
  const Isometry3d T_world_palm = T_world_wrist * about_y(joints[0]) * about_x(joints[1]);
  points.col(0) = T_world_palm.translation();
  place_thumb(points, joints, shape, T_world_palm);
  for (const hand::FingerName finger : {hand::FingerName::first, hand::FingerName::middle,
                                        hand::FingerName::ring, hand::FingerName::little}) {
    place_finger(points, finger, joints, shape, T_world_palm);
  }
  return points;
}

const std::array<HumanBone, 20>& human_bones() {
  static const auto bones = [] {
    constexpr std::array<double, 3> kFinger = {0.010, 0.0085, 0.0075};
    constexpr std::array<double, 3> kThumbRadii = {0.014, 0.011, 0.009};
    std::array<HumanBone, 20> result{};
    std::size_t next = 0;
    for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
      const int first = keypoint(static_cast<hand::FingerName>(finger), 0);
      result[next++] = {0, first, 0.013};
      for (int i = 0; i < 3; ++i) {
        const auto k = static_cast<std::size_t>(i);
        result[next++] = {first + i, first + i + 1, finger == 0 ? kThumbRadii[k] : kFinger[k]};
      }
    }
    return result;
  }();
  return bones;
}

Eigen::Matrix3d palm_frame(const Vector3d& wrist, const Vector3d& first_knuckle,
                           const Vector3d& middle_knuckle, const Vector3d& little_knuckle) {
  const Vector3d along = middle_knuckle - wrist;
  const Vector3d back = along.cross(first_knuckle - little_knuckle);
  if (!(back.norm() > 1e-9))
    throw BadInput("the knuckles of a hand lie on one line with its wrist");
  Eigen::Matrix3d R;
  R.col(2) = along.normalized();
  R.col(1) = back.normalized();
  R.col(0) = R.col(1).cross(R.col(2));
  return R;
}

Eigen::Matrix3d palm_frame(const HandKeypoints& k) {
  return palm_frame(k.col(0), k.col(keypoint(hand::FingerName::first, 0)),
                    k.col(keypoint(hand::FingerName::middle, 0)),
                    k.col(keypoint(hand::FingerName::little, 0)));
}

}  // namespace palpate::learning
