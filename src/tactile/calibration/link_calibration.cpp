// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/calibration/link_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::tactile {
namespace {

void check(const hand::Description& hand, const TipPosture& tip) {
  if (tip.finger < 0 || tip.finger >= hand.finger_count()) {
    throw BadInput(
        fmt::format("fingertip of finger {}: there are {}", tip.finger, hand.finger_count()));
  }
  if (!tip.joints.allFinite()) {
    throw BadInput(
        fmt::format("posture of a fingertip with joints that sum up to {}", tip.joints.sum()));
  }
}

void check(const hand::Description& hand, const TipOnPlane& touch) {
  check(hand, touch.tip);
  if (!(touch.sigma > 0) || !std::isfinite(touch.sigma)) {
    throw BadInput(fmt::format("touch of a plane with a sigma of {} m", touch.sigma));
  }
  if (!touch.p.allFinite()) {
    throw BadInput(fmt::format("touch of a plane at ({}, {}, {}) of the fingertip", touch.p.x(),
                               touch.p.y(), touch.p.z()));
  }
  if (!touch.T_mount_plane.matrix().allFinite()) {
    throw BadInput("touch of a plane whose pose holds a value that is not finite");
  }
}

// The unknowns: displacements of all links, one after the other, m; then shift and turn of the hand
// on the mount, in the mount's frame; then the plane's height and its turns about x and y.
constexpr int kMount = 6, kPlane = 3;

Eigen::Index link_unknowns(const hand::Description& hand) {
  return 3 * static_cast<Eigen::Index>(hand.links.size());
}

/// A point of the fingertip in the mount's frame.
Eigen::Vector3d in_mount(const hand::Description& hand, const TipPosture& tip,
                         const Eigen::Vector3d& p) {
  const int link = hand.fingers[static_cast<std::size_t>(tip.finger)].link;
  return hand::forward_kinematics(hand, tip.joints)[static_cast<std::size_t>(link)] * p;
}

/// Derivative of a point of the fingertip, in the mount's frame, by all unknowns.
Eigen::Matrix3Xd point_jacobian(const hand::Description& hand, const TipPosture& tip,
                                const Eigen::Vector3d& p) {
  const auto T_mount_link = hand::forward_kinematics(hand, tip.joints);
  const Eigen::Index links = link_unknowns(hand);
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, links + kMount + kPlane);
  for (const int link :
       hand::misplaced_links(hand, hand.fingers[static_cast<std::size_t>(tip.finger)].link)) {
    const int parent = hand.links[static_cast<std::size_t>(link)].parent;
    Eigen::Matrix3d R_mount_parent = Eigen::Matrix3d::Identity();
    if (parent >= 0) R_mount_parent = T_mount_link[static_cast<std::size_t>(parent)].linear();
    J.middleCols<3>(3 * link) = R_mount_parent;
  }
  J.middleCols<3>(links).setIdentity();
  J.middleCols<3>(links + 3) = -skew(in_mount(hand, tip, p));
  return J;
}

Eigen::VectorXd prior_variances(const hand::Description& hand, const MountPrior& prior) {
  const Eigen::Index links = link_unknowns(hand);
  const auto square = [](double sigma) { return sigma * sigma; };
  Eigen::VectorXd variances(links + kMount + kPlane);
  variances.head(links).setConstant(square(hand.kinematic_error) / 3);
  variances.segment<3>(links).setConstant(square(prior.mount));
  variances.segment<3>(links + 3).setConstant(square(prior.mount_angle));
  variances.tail<kPlane>() << square(prior.table_height), square(prior.table_tilt),
      square(prior.table_tilt);
  return variances;
}

/// Normal distribution of the unknowns.
class UnknownsBelief {
 public:
  explicit UnknownsBelief(const Eigen::VectorXd& variances)
      : mean_(Eigen::VectorXd::Zero(variances.size())), covariance_(variances.asDiagonal()) {}

  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }

  /// Kalman's update with row . unknowns = value.
  void update(const Eigen::VectorXd& row, double value, double sigma) {
    const Eigen::VectorXd across = covariance_ * row;
    const double variance = sigma * sigma + row.dot(across);
    mean_ += across * ((value - row.dot(mean_)) / variance);
    covariance_ -= across * across.transpose() / variance;
  }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
};

/// How a point's distance from its plane changes with the unknowns.
Eigen::VectorXd distance_row(const hand::Description& hand, const TipOnPlane& touch) {
  const Eigen::Vector3d normal = touch.T_mount_plane.linear().col(2);
  Eigen::VectorXd row = point_jacobian(hand, touch.tip, touch.p).transpose() * normal;
  const Eigen::Vector3d q = touch.T_mount_plane.inverse() * in_mount(hand, touch.tip, touch.p);
  row.tail<kPlane>() << -1, -q.y(), q.x();
  return row;
}

/// Sum of J'J over the uses: the trace of its product with a covariance is the tips' variance.
Eigen::MatrixXd importance(const hand::Description& hand, std::span<const TipPosture> uses) {
  const Eigen::Index size = link_unknowns(hand) + kMount + kPlane;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  for (const TipPosture& tip : uses) {
    const Eigen::Matrix3Xd J = point_jacobian(hand, tip, Eigen::Vector3d::Zero());
    sum += J.transpose() * J;
  }
  return sum;
}

/// The link error with which the tips would be as uncertain as they are.
double remaining_error(const hand::Description& hand, std::span<const TipPosture> uses,
                       const Eigen::MatrixXd& covariance) {
  double links = 0;
  for (const TipPosture& tip : uses) {
    const int link = hand.fingers[static_cast<std::size_t>(tip.finger)].link;
    links += static_cast<double>(hand::misplaced_links(hand, link).size());
  }
  return std::sqrt(importance(hand, uses).cwiseProduct(covariance).sum() / links);
}

Eigen::Isometry3d motion(const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = shift;
  if (turn.norm() > 0) T.rotate(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  return T;
}

hand::Description moved_hand(hand::Description hand, const Eigen::VectorXd& unknowns) {
  const Eigen::Index links = link_unknowns(hand);
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    hand::Link& link = hand.links[i];
    link.T_parent_link.translation() += unknowns.segment<3>(3 * static_cast<Eigen::Index>(i));
    if (link.parent >= 0) continue;
    link.T_parent_link =
        motion(unknowns.segment<3>(links), unknowns.segment<3>(links + 3)) * link.T_parent_link;
  }
  return hand;
}

Eigen::Isometry3d moved_plane(const Eigen::VectorXd& unknowns) {
  const Eigen::Vector3d plane = unknowns.tail<kPlane>();
  return motion({0, 0, plane[0]}, {plane[1], plane[2], 0});
}

}  // namespace

double distance_from_plane(const hand::Description& hand, const TipOnPlane& touch) {
  check(hand, touch);
  return (touch.T_mount_plane.inverse() * in_mount(hand, touch.tip, touch.p)).z();
}

HandCalibration calibrate_links(const hand::Description& hand, std::span<const TipOnPlane> touches,
                                std::span<const TipPosture> uses, const MountPrior& prior) {
  for (const TipOnPlane& touch : touches) check(hand, touch);
  for (const TipPosture& tip : uses) check(hand, tip);
  if (!(hand.kinematic_error >= 0) || !std::isfinite(hand.kinematic_error)) {
    throw BadInput(
        fmt::format("calibrating a hand whose kinematic_error is {} m", hand.kinematic_error));
  }
  const Eigen::VectorXd variances = prior_variances(hand, prior);
  if (touches.empty() || uses.empty() || variances.isZero(0)) return {hand};
  UnknownsBelief belief(variances);
  for (const TipOnPlane& touch : touches) {
    belief.update(distance_row(hand, touch), -distance_from_plane(hand, touch), touch.sigma);
  }
  HandCalibration found{moved_hand(hand, belief.mean()), moved_plane(belief.mean())};
  found.hand.kinematic_error = remaining_error(hand, uses, belief.covariance());
  return found;
}

std::vector<std::size_t> choose_touches(const hand::Description& hand,
                                        std::span<const TipOnPlane> candidates, std::size_t count,
                                        std::span<const TipPosture> uses, const MountPrior& prior) {
  for (const TipOnPlane& touch : candidates) check(hand, touch);
  for (const TipPosture& tip : uses) check(hand, tip);
  std::vector<Eigen::VectorXd> rows;
  for (const TipOnPlane& touch : candidates) rows.push_back(distance_row(hand, touch));
  const Eigen::MatrixXd wanted = importance(hand, uses);
  UnknownsBelief belief(prior_variances(hand, prior));
  std::vector<std::size_t> chosen;
  while (chosen.size() < std::min(count, candidates.size())) {
    const Eigen::MatrixXd lessened = belief.covariance() * wanted * belief.covariance();
    std::size_t best = 0;
    double most = -1;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double variance =
          std::pow(candidates[i].sigma, 2) + rows[i].dot(belief.covariance() * rows[i]);
      const double gain = rows[i].dot(lessened * rows[i]) / variance;
      const bool taken = std::find(chosen.begin(), chosen.end(), i) != chosen.end();
      if (taken || gain <= most) continue;
      most = gain;
      best = i;
    }
    belief.update(rows[best], 0, candidates[best].sigma);
    chosen.push_back(best);
  }
  return chosen;
}

}  // namespace palpate::tactile
