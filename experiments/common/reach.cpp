// SPDX-License-Identifier: Apache-2.0
#include "reach.hpp"

#include <utility>

#include "palpate/core/angle.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::experiment {
namespace {

constexpr double kPitches[] = {1.35, 1.0, 0.7, 0.4, 0.1};  // rad, of the finger below the horizon
constexpr double kAside[] = {0.0, -0.5, 0.5};              // rad, that it points past the object
constexpr int kRolls = 8;

/// Orientations of the mount in which the finger points down or inwards from the azimuth.
std::vector<Eigen::Matrix3d> orientations(const PointingFinger& finger, double azimuth) {
  const Eigen::Matrix3d R_x_finger =
      Eigen::Quaterniond::FromTwoVectors(finger.direction(), Eigen::Vector3d::UnitX())
          .toRotationMatrix();
  std::vector<Eigen::Matrix3d> result;
  for (const double pitch : kPitches) {
    for (const double aside : kAside) {
      for (int roll = 0; roll < kRolls; ++roll) {
        const Eigen::Quaterniond q =
            Eigen::AngleAxisd(azimuth + kPi + aside, Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(2 * kPi * roll / kRolls, Eigen::Vector3d::UnitX());
        result.push_back(q.toRotationMatrix() * R_x_finger);
      }
    }
  }
  return result;
}

}  // namespace

Reach::Reach(const geometry::KnownObject& object, const Eigen::Isometry3d& T_world_object,
             hand::Description hand)
    : scene_(object, hand, planning::CollisionOptions{.allowed_depth = 0.002, .self = false}),
      hand_(std::move(hand)) {
  scene_.place(T_world_object);
}

bool Reach::free(const PointingFinger& finger, const Eigen::Matrix3d& R_world_mount,
                 const Eigen::Vector3d& center) {
  return !scene_.deepest_collision(finger.command(R_world_mount, center).mount, finger.joints());
}

Stand Reach::best_stand(int finger, double azimuth, const std::vector<Eigen::Vector3d>& centers) {
  std::optional<Stand> best;
  for (const auto& posture : pointing_postures(finger)) {
    const PointingFinger pointing(hand_, finger, posture);
    for (const Eigen::Matrix3d& R : orientations(pointing, azimuth)) {
      int count = 0;
      for (const auto& center : centers) count += free(pointing, R, center);
      const double share = static_cast<double>(count) / static_cast<double>(centers.size());
      if (!best || share > best->free_share) best = Stand{pointing, R, share};
    }
  }
  return *best;
}

bool Reach::any_finger_reaches(double azimuth, const Eigen::Vector3d& center) {
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    for (const auto& posture : pointing_postures(finger)) {
      const PointingFinger pointing(hand_, finger, posture);
      for (const Eigen::Matrix3d& R : orientations(pointing, azimuth)) {
        if (free(pointing, R, center)) return true;
      }
    }
  }
  return false;
}

}  // namespace palpate::experiment
