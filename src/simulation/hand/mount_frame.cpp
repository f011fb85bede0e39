// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/mount_frame.hpp"

#include <fmt/format.h>

#include <numbers>

namespace palpate::simulation {
namespace {

constexpr double kAgainst = -0.7;  // cosine between the ways of fingers that close on one another
constexpr double kSameWay = 0.5;   // and between the directions in which such fingers point

constexpr double kFarTurned = 45, kFarAway = 0.1;  // deg, m
constexpr double kAsFar = 0.7;  // of the others' reach: a thumb at the side of a palm has less

/// The part of a vector across a direction of length 1.
Eigen::Vector3d across(const Eigen::Vector3d& vector, const Eigen::Vector3d& direction) {
  return vector - vector.dot(direction) * direction;
}

/// Means of the fingers other than the thumb.
struct Others {
  Eigen::Vector3d rays = Eigen::Vector3d::Zero();  ///< sum of directions from the palm to the tips
  Eigen::Vector3d way = rays, open = rays, half = rays;  ///< of a tip, m
};

Others others_of(const ClosingTips& tips, const Eigen::Vector3d& p_palm, std::size_t thumb) {
  Others others;
  const double count = static_cast<double>(tips.open.size() - 1);
  for (std::size_t i = 0; i < tips.open.size(); ++i) {
    if (i == thumb) continue;
    others.rays += (tips.open[i] - p_palm).normalized();
    others.way += (tips.closed[i] - tips.open[i]) / count;
    others.open += tips.open[i] / count;
    others.half += tips.half[i] / count;
  }
  return others;
}

}  // namespace

bool has_mount(const HandNotes& notes) {
  return notes.has_mount || !notes.mount_xyz.isZero(0) || !notes.mount_rpy.isZero(0);
}

Eigen::Isometry3d given_mount(const HandNotes& notes) {
  const Eigen::Vector3d rpy = notes.mount_rpy * std::numbers::pi / 180;
  return Eigen::Translation3d(notes.mount_xyz) *
         Eigen::Quaterniond(Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
}

std::string far_from(const Eigen::Isometry3d& given, const Eigen::Isometry3d& derived) {
  const Eigen::Matrix3d R_given_derived = given.linear() * derived.linear().transpose();
  const double angle = Eigen::AngleAxisd(R_given_derived).angle() * 180 / std::numbers::pi;
  const double distance = (given.inverse().translation() - derived.inverse().translation()).norm();
  if (angle < kFarTurned && distance < kFarAway) return {};
  return fmt::format("the given mount is {:.0f} deg and {:.0f} mm from the one that is derived",
                     angle, 1e3 * distance);
}

MountFrame derive_mount(const ClosingTips& tips, const Eigen::Vector3d& p_palm, int thumb) {
  const auto opposed = static_cast<std::size_t>(thumb);
  const Others others = others_of(tips, p_palm, opposed);
  const Eigen::Vector3d ray = others.rays.normalized();
  const Eigen::Vector3d thumb_way = tips.closed[opposed] - tips.open[opposed];
  const Eigen::Vector3d thumb_ray = (tips.open[opposed] - p_palm).normalized();
  const double reach = (tips.open[opposed] - p_palm).dot(ray);
  const double cosine =
      across(others.way, ray).normalized().dot(across(thumb_way, ray).normalized());
  MountFrame frame;
  frame.points_down = cosine < kAgainst && thumb_ray.dot(ray) > kSameWay &&
                      reach > kAsFar * (others.open - p_palm).dot(ray);
  const Eigen::Vector3d z =
      -(frame.points_down ? Eigen::Vector3d(others.rays + thumb_ray) : across(others.way, ray))
           .normalized();
  const Eigen::Vector3d along = frame.points_down ? Eigen::Vector3d(others.way - thumb_way) : ray;
  const Eigen::Vector3d x = across(along, z).normalized();
  Eigen::Matrix3d R;  // columns: the mount's axes in the root's frame
  R << x, z.cross(x), z;
  frame.T_root_mount.linear() = R;
  frame.T_root_mount.translation() = 0.5 * (others.half + tips.half[opposed]);
  return frame;
}

}  // namespace palpate::simulation
