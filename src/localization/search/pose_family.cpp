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

/// How far turns of an object of revolution about its line are from a family about a free axis: for
/// each turn a bound of its error of rotation, which is at least the swing, what remains when a
/// turn about the free axis has been taken off.
class Swings {
 public:
  Swings(const Eigen::Quaterniond& pose, const Eigen::Quaterniond& family,
         const Eigen::Vector3d& axis, const SymmetryGroup::Turns& turns) {
    // The turn by an angle t is cos(t/2) + sin(t/2) line.
    const Eigen::Quaterniond even = pose * turns.first * family.conjugate();
    const Eigen::Quaterniond odd = pose * turns.line * turns.first * family.conjugate();
    const Eigen::Vector2d a(even.w(), even.vec().dot(axis)), b(odd.w(), odd.vec().dot(axis));
    middle_ = (a.squaredNorm() + b.squaredNorm()) / 2;
    cosine_ = (a.squaredNorm() - b.squaredNorm()) / 2;
    sine_ = a.dot(b);
  }

  /// The squared cosine of half a swing, rounding allowed for; about 0 from pi on.
  static double least(double swing) {
    constexpr double kRounding = 1e-6;
    const double cosine = std::cos(std::min(swing, pi) / 2);
    return cosine * cosine - kRounding;
  }
  /// That of the swing after a turn.
  double of(const SymmetryGroup::Turns::Turn& turn) const {
    return middle_ + cosine_ * turn.cosine + sine_ * turn.sine;
  }
  /// Of any turn at most.
  double most() const { return middle_ + std::hypot(cosine_, sine_); }

 private:
  double middle_, cosine_, sine_;
};

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
  if (!symmetries.turns().empty()) return match_turns(pose, symmetries);
  Match best = match_image(pose);
  for (const Eigen::Quaterniond& symmetry : symmetries.rotations()) {
    Match other = match_image({pose.q * symmetry, pose.t});
    if (relative_error(other.error) < relative_error(best.error)) best = std::move(other);
  }
  return best;
}

/// As of all listed rotations in their order, without those that are too far by their swing.
PoseFamily::Match PoseFamily::match_turns(const PosePoint& pose,
                                          const Symmetries& symmetries) const {
  using Turn = SymmetryGroup::Turns::Turn;
  Match best = match_image(pose);
  double least = relative_error(best.error);
  std::optional<std::size_t> place;  // of the best; of equal ones the first
  const auto compare = [&](const Turn& turn) {
    Match other = match_image({pose.q * symmetries.rotations()[turn.index], pose.t});
    const double error = relative_error(other.error);
    if (error > least || (error == least && !(place && turn.index < *place))) return;
    best = std::move(other);
    least = error;
    place = turn.index;
  };
  for (const auto& listed : symmetries.turns()) {
    const Swings swings(pose.q, pose_.q, axis_->direction, listed);
    const auto swing = [&](const Turn& turn) { return swings.of(turn); };
    if (listed.turns.empty()) continue;
    compare(*std::ranges::max_element(listed.turns, {}, swing));
    // The limit of the nearest turn serves for all: a few more are compared than need be.
    const double limit = Swings::least(least * PoseTolerance{}.rotation);
    for (const Turn& turn : listed.turns) {
      if (swings.of(turn) >= limit) compare(turn);
    }
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
  const auto holds = [&](const Eigen::Quaterniond& s) {
    return relative_error(match_image({pose.q * s, pose.t}).error, tolerance) <= 1;
  };
  if (symmetries.turns().empty()) return std::ranges::any_of(symmetries.rotations(), holds);
  const double least = Swings::least(tolerance.rotation);
  return std::ranges::any_of(symmetries.turns(), [&](const SymmetryGroup::Turns& listed) {
    const Swings swings(pose.q, pose_.q, axis_->direction, listed);
    return swings.most() >= least && std::ranges::any_of(listed.turns, [&](const auto& turn) {
             return swings.of(turn) >= least && holds(symmetries.rotations()[turn.index]);
           });
  });
}

PoseFamily family_of(const Mode& mode) {
  const PosePoint pose(mode.T_frame_object);
  return mode.free_axis ? PoseFamily(pose, *mode.free_axis) : PoseFamily(pose);
}

Matrix6d covariance_along(const Mode& mode, double spread) {
  const Eigen::Vector3d& axis = mode.free_axis->direction;
  Vector6d along;  // change of the pose per radian about the free axis
  along << axis, axis.cross(mode.T_frame_object.translation() - mode.free_axis->point);
  Matrix6d across = Matrix6d::Identity();  // turns a deviation back till none is about the axis
  across.leftCols<3>() -= along * axis.transpose();
  return across * mode.covariance * across.transpose() +
         spread * spread * along * along.transpose();
}

std::size_t take(const PoseFamily& family, const PoseFamily::Symmetries& symmetries,
                 std::vector<PosePoint>& poses) {
  return std::erase_if(poses, [&](const PosePoint& p) { return family.contains(p, symmetries); });
}

double relative_error(const PoseError& error, const PoseTolerance& tolerance) {
  return std::max(error.rotation / tolerance.rotation, error.translation / tolerance.translation);
}

}  // namespace palpate::localization
