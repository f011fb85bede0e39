// SPDX-License-Identifier: Apache-2.0
#include "estimation/prior_after_grasp.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "estimation/closing_push.hpp"
#include "estimation/in_hand_motion.hpp"
#include "estimation/rocking.hpp"
#include "estimation/tracked_pose.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::estimation {
namespace {

constexpr int kSlides = 2;        // how often a grasp may slide, each time
constexpr double kFarther = 3.0;  // so many times as far
constexpr double kMotionError =
    0.25;                            // of the motion in the hand that the fingertips measure, sigma
constexpr double kSwing = 0.02;      // rad, sigma of a turn that was tracked in two fingertips
constexpr double kUntracked = 0.05;  // rad, sigma of a turn in two fingertips that was not
constexpr double kSteadyMass = 0.2;  // kg, of an object that closing fingers do not push
constexpr double kPushShare = 0.6;   // of the way that a fingertip pushed it, sigma
constexpr double kPushArm = 0.04;    // m, of a push that turns it
constexpr double kStirred = 3.0;     // so many times as far, where it was turned or grasped again

using localization::PosePrior;

/// The last lift up to the instant.
std::optional<std::size_t> lifted(const GraspHistory& held) {
  std::optional<std::size_t> last;
  for (const std::size_t reading : held.log.all(TouchEvent::held)) {
    if (reading > held.closed && reading <= held.at) last = reading;
  }
  return last;
}

/// How the object has moved from the closed hand to the lifted one, in the hand's mount, as its
/// contacts wander over it.
/// @param posterior  at the closed hand, in the mount
Eigen::Isometry3d tracked_motion(const GraspHistory& held, std::size_t lifted,
                                 const localization::Posterior& posterior) {
  return track_best_mode(held, lifted, posterior).T_frame_object *
         posterior.modes.front().T_frame_object.inverse();
}

/// What the fingertips say of how the object has moved in the hand.
struct MeasuredMotion {
  InHandMotion motion;
  double turn = 0, way = 0;     ///< rad, m
  double share = 1, swing = 0;  ///< that it is so; rad, sigma about the loose axes
};

/// Where two fingertips hold it, it may have swung as it was tracked, or not at all.
/// @param posterior  at the closed hand, in the mount
std::vector<MeasuredMotion> measured_motions(const GraspHistory& held,
                                             const localization::Posterior& posterior) {
  const auto move_from = [&](std::size_t first) {
    return in_hand_motion(held.hand, held.log, first, held.at, held.options.errors);
  };
  MeasuredMotion measured{move_from(held.closed)};
  const Eigen::Vector3d p = posterior.modes.front().T_frame_object.translation();
  measured.turn = Eigen::AngleAxisd(measured.motion.T.linear()).angle();
  measured.way = (measured.motion.T * p - p).norm();
  const auto last = lifted(held);
  if (measured.motion.loose.empty() || !last) return {measured};
  const Eigen::Isometry3d swing = tracked_motion(held, *last, posterior);
  const double angle = Eigen::AngleAxisd(swing.linear()).angle();
  MeasuredMotion swung = measured;
  swung.motion.T = move_from(*last).T * swing;
  swung.share = measured.share = 0.5;
  swung.swing = std::hypot(kSwing, kMotionError * angle);
  measured.swing = std::hypot(kUntracked, kMotionError * angle);
  return {swung, measured};
}

/// By how much closing, pressing and lifting move the object in the hand, times `scale`, beside
/// what the fingertips measure of that motion, which is off by a share of itself.
Matrix6d motion_covariance(const EstimationOptions& options, const MeasuredMotion& measured,
                           double scale) {
  const double turn = scale * std::hypot(options.motion_angle_sigma, kMotionError * measured.turn);
  const double way = scale * std::hypot(options.motion_sigma, kMotionError * measured.way);
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(turn * turn), Eigen::Vector3d::Constant(way * way);
  return variance.asDiagonal();
}

/// By how much it may have turned about an axis, unsensed.
void loosen(const localization::FreeAxis& axis, double sigma, PosePrior& prior) {
  for (auto& component : prior.components) {
    Vector6d turn;
    turn.head<3>() = axis.direction;
    turn.tail<3>() = axis.direction.cross(component.T_frame_object.translation() - axis.point);
    component.covariance += sigma * sigma * turn * turn.transpose();
  }
}

/// In the hand's mount, when it closed.
Eigen::Vector3d up_at_closing(const GraspHistory& held) {
  return held.log.readings[held.closed].mount.pose().linear().row(2);
}

/// Motions that closing may cause besides, in one mode.
struct Disturbance {
  Matrix6d pushed, rocked;  ///< covariances

  /// Where it has moved so many times as far; what rocks ends where it is stopped by the hand.
  [[nodiscard]] Matrix6d covariance(double times) const {
    const double rocking = std::min(times, kFarther);
    return times * times * pushed + rocking * rocking * rocked;
  }
};
using Disturbances = std::vector<Disturbance>;

/// An object slides over the table until a second finger meets it, for it is light, or fingertips
/// have pushed it; in the hand's mount.
Matrix6d pushed_covariance(const GraspHistory& held) {
  const double times = std::clamp(kSteadyMass / held.model.object().mass, 1.0, kFarther);
  const double more = times * times - 1;
  const double push = kPushShare * closing_push(held.hand, held.log, held.closed);
  const EstimationOptions& options = held.options;
  const Eigen::Vector3d up = up_at_closing(held);
  const Eigen::Matrix3d vertical = up * up.transpose();
  Matrix6d covariance = Matrix6d::Zero();
  covariance.topLeftCorner<3, 3>() =
      (more * std::pow(options.motion_angle_sigma, 2) + std::pow(push / kPushArm, 2)) * vertical;
  covariance.bottomRightCorner<3, 3>() = (more * std::pow(options.motion_sigma, 2) + push * push) *
                                         (Eigen::Matrix3d::Identity() - vertical);
  return covariance;
}

/// Pushed it slides, and what lies on a round side rocks as fingers close one after the other.
/// @param resting  at closing, in the hand's mount
Disturbances disturbances(const GraspHistory& held, const localization::Posterior& resting) {
  const Matrix6d pushed = pushed_covariance(held);
  const Eigen::Vector3d up = up_at_closing(held);
  Disturbances result;
  for (const auto& mode : resting.modes) {
    result.push_back({pushed, rocking_covariance(held.model.object(), mode.T_frame_object, up)});
  }
  return result;
}

/// @param disturbances  one a mode; empty: none
localization::Posterior disturbed(localization::Posterior posterior,
                                  const Disturbances& disturbances, double times) {
  for (std::size_t i = 0; i < disturbances.size(); ++i) {
    posterior.modes[i].covariance += disturbances[i].covariance(times);
  }
  return posterior;
}

/// @param before  at the reading `closed`, in the hand's mount
/// @param scale   of the motions that the fingertips do not measure
/// @param disturbances  such motions besides
PosePrior after_motion(const GraspHistory& held, const localization::Posterior& before,
                       double scale, const Disturbances& disturbances) {
  const EstimationOptions& options = held.options;
  PosePrior prior;
  for (const MeasuredMotion& measured : measured_motions(held, before)) {
    double share = measured.share, farther = 1;
    for (int slides = 0; slides <= kSlides; ++slides) {
      localization::Posterior moved = disturbed(before, disturbances, farther);
      transform(measured.motion.T, moved);
      PosePrior part = localization::prior_from_modes(
          moved, motion_covariance(options, measured, scale * farther));
      for (const auto& axis : measured.motion.loose) loosen(axis, measured.swing, part);
      localization::append(part, slides < kSlides ? share * (1 - options.slide_share) : share,
                           prior);
      share *= options.slide_share;
      farther *= kFarther;
    }
  }
  localization::spread_elsewhere(options.elsewhere, prior);
  return prior;
}

/// Whether it has been moved on purpose since the hand closed, up to the instant.
bool moved_since(const GraspHistory& held) {
  return std::ranges::any_of(held.log.all(TouchEvent::table_touched), [&](std::size_t reading) {
    return reading > held.closed && reading <= held.at;
  });
}

}  // namespace

PosePrior prior_after_grasp(const GraspHistory& held, localization::Posterior resting) {
  transform(held.log.readings[held.closed].mount.pose().inverse(), resting);
  const bool stirred = held.log.has_opened() || moved_since(held);
  return after_motion(held, resting, stirred ? kStirred : 1.0, disturbances(held, resting));
}

PosePrior prior_after_lift(const GraspHistory& held, const localization::Posterior& before_lift) {
  return after_motion(held, before_lift, moved_since(held) ? kStirred : 1.0, {});
}

PosePrior either_of(const PosePrior& one, const PosePrior& other) {
  PosePrior prior;
  localization::append(one, 0.5, prior);
  localization::append(other, 0.5, prior);
  prior.floor = std::max(one.floor, other.floor);
  return prior;
}

}  // namespace palpate::estimation
