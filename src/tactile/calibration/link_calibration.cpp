// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/calibration/link_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

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
  const auto& n = touch.plane.normal();
  if (!touch.plane.coeffs().allFinite() || std::abs(n.norm() - 1) > 1e-6) {
    throw BadInput(fmt::format("touch of a plane with the normal ({}, {}, {}), {} m away", n.x(),
                               n.y(), n.z(), touch.plane.offset()));
  }
}

/// Derivative of the fingertip's place in the base's frame by the displacements of all links.
Eigen::Matrix3Xd displacement_jacobian(const hand::Description& hand, const TipPosture& tip) {
  const auto T_base_link = hand::forward_kinematics(hand, tip.joints);
  const auto links = static_cast<Eigen::Index>(hand.links.size());
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, 3 * links);
  for (const int link :
       hand::misplaced_links(hand, hand.fingers[static_cast<std::size_t>(tip.finger)].link)) {
    const int parent = hand.links[static_cast<std::size_t>(link)].parent;
    Eigen::Matrix3d R_base_parent = Eigen::Matrix3d::Identity();
    if (parent >= 0) R_base_parent = T_base_link[static_cast<std::size_t>(parent)].linear();
    J.middleCols<3>(3 * link) = R_base_parent;
  }
  return J;
}

/// Normal distribution of the links' displacements, one after the other, m.
class LinkBelief {
 public:
  explicit LinkBelief(const hand::Description& hand)
      : mean_(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(hand.links.size()))),
        covariance_(Eigen::MatrixXd::Identity(mean_.size(), mean_.size()) * hand.kinematic_error *
                    hand.kinematic_error / 3) {}

  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }

  /// Kalman's update with row . displacements = value.
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

/// How a point's distance from its plane changes with the displacements.
Eigen::VectorXd distance_row(const hand::Description& hand, const TipOnPlane& touch) {
  return displacement_jacobian(hand, touch.tip).transpose() * touch.plane.normal();
}

/// Sum of J'J over the uses: the trace of its product with a covariance is the tips' variance.
Eigen::MatrixXd importance(const hand::Description& hand, std::span<const TipPosture> uses) {
  const auto size = 3 * static_cast<Eigen::Index>(hand.links.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  for (const TipPosture& tip : uses) {
    const Eigen::Matrix3Xd J = displacement_jacobian(hand, tip);
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

}  // namespace

double distance_from_plane(const hand::Description& hand, const TipOnPlane& touch) {
  check(hand, touch);
  const int link = hand.fingers[static_cast<std::size_t>(touch.tip.finger)].link;
  const auto T_base_link = hand::forward_kinematics(hand, touch.tip.joints);
  return touch.plane.signedDistance(T_base_link[static_cast<std::size_t>(link)] * touch.p);
}

hand::Description calibrate_links(const hand::Description& hand,
                                  std::span<const TipOnPlane> touches,
                                  std::span<const TipPosture> uses) {
  for (const TipOnPlane& touch : touches) check(hand, touch);
  for (const TipPosture& tip : uses) check(hand, tip);
  if (!(hand.kinematic_error >= 0) || !std::isfinite(hand.kinematic_error)) {
    throw BadInput(
        fmt::format("calibrating a hand whose kinematic_error is {} m", hand.kinematic_error));
  }
  if (touches.empty() || uses.empty() || hand.kinematic_error == 0) return hand;
  LinkBelief belief(hand);
  for (const TipOnPlane& touch : touches) {
    belief.update(distance_row(hand, touch), -distance_from_plane(hand, touch), touch.sigma);
  }
  hand::Description calibrated = hand;
  for (std::size_t link = 0; link < hand.links.size(); ++link) {
    calibrated.links[link].T_parent_link.translation() +=
        belief.mean().segment<3>(3 * static_cast<Eigen::Index>(link));
  }
  calibrated.kinematic_error = remaining_error(hand, uses, belief.covariance());
  return calibrated;
}

std::vector<std::size_t> choose_touches(const hand::Description& hand,
                                        std::span<const TipOnPlane> candidates, std::size_t count,
                                        std::span<const TipPosture> uses) {
  for (const TipOnPlane& touch : candidates) check(hand, touch);
  for (const TipPosture& tip : uses) check(hand, tip);
  std::vector<Eigen::VectorXd> rows;
  for (const TipOnPlane& touch : candidates) rows.push_back(distance_row(hand, touch));
  const Eigen::MatrixXd wanted = importance(hand, uses);
  LinkBelief belief(hand);
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
