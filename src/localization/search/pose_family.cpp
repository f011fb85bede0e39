// SPDX-License-Identifier: Apache-2.0
#include "localization/search/pose_family.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::localization {
namespace {

using std::numbers::pi;

/// The angle of -extent..extent nearest to `angle` (-pi..pi) on the circle.
double nearest_turn(double angle, double extent) {
  if (std::abs(angle) <= extent) return angle;
  const double beyond = std::abs(angle) - extent;
  const double round_the_back = 2 * pi - std::abs(angle) - extent;
  return std::copysign(extent, beyond <= round_the_back ? angle : -angle);
}

double rotation_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond between = a.conjugate() * b;
  return 2 * std::atan2(between.vec().norm(), std::abs(between.w()));
}

}  // namespace

PosePoint PoseFamily::at(double angle) const {
  if (!axis_) return pose_;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, axis_->direction));
  return {turn * pose_.q, axis_->point + turn * (pose_.t - axis_->point)};
}

PoseFamily::Match PoseFamily::match_image(const PosePoint& image) const {
  double along = 0;
  if (axis_) {
    const Eigen::Quaterniond turn = image.q * pose_.q.conjugate();
    const double angle = 2 * std::atan2(turn.vec().dot(axis_->direction), turn.w());
    along = nearest_turn(std::remainder(angle, 2 * pi), axis_->extent);
  }
  const PosePoint member = at(along);
  return {image, along, {rotation_between(image.q, member.q), (image.t - member.t).norm()}};
}

PoseFamily::Match PoseFamily::match(const PosePoint& pose, const Symmetries& symmetries) const {
  if (!axis_)
    return match_image({pose.q * symmetries.nearest(pose.q.conjugate() * pose_.q), pose.t});
  Match best = match_image(pose);
  for (const Eigen::Quaterniond& symmetry : symmetries.rotations()) {
    Match other = match_image({pose.q * symmetry, pose.t});
    if (relative_error(other.error) < relative_error(best.error)) best = std::move(other);
  }
  return best;
}

bool PoseFamily::contains(const PosePoint& pose, const Symmetries& symmetries,
                          const PoseTolerance& tolerance) const {
  if (!axis_) {
    if ((pose.t - pose_.t).norm() > tolerance.translation) return false;
    const double least = std::cos(tolerance.rotation / 2);
    const Eigen::Quaterniond between = pose.q.conjugate() * pose_.q;
    return std::abs(between.dot(symmetries.nearest(between))) >= least;
  }
  return std::ranges::any_of(symmetries.rotations(), [&](const Eigen::Quaterniond& s) {
    return relative_error(match_image({pose.q * s, pose.t}).error, tolerance) <= 1;
  });
}

PoseFamily family_of(const Mode& mode) {
  const PosePoint pose(mode.T_frame_object);
  return mode.free_axis ? PoseFamily(pose, *mode.free_axis) : PoseFamily(pose);
}

std::size_t take(const PoseFamily& family, const PoseFamily::Symmetries& symmetries,
                 std::vector<PosePoint>& poses) {
  return std::erase_if(poses, [&](const PosePoint& p) { return family.contains(p, symmetries); });
}

double relative_error(const PoseError& error, const PoseTolerance& tolerance) {
  return std::max(error.rotation / tolerance.rotation, error.translation / tolerance.translation);
}

}  // namespace palpate::localization
