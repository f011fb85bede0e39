// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/retargeting.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <memory>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::learning {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using hand::FingerName;
using hand::HandPoint;
using learning::HandKeypoints;

constexpr double kMinTip = 0.7;        // of its link; a link's center is at about one half
constexpr double kLargestTurn = 0.15;  // rad, of the root against the human's palm
constexpr int kFirstSolves = 30;       // in the first frame, each from where the last one ended
constexpr double kFirstStep = 1.5;     // rad, of a joint in each of them
constexpr int kVectors = 2 * hand::kShadowFingers;
constexpr int kRootCoordinates = 6;      // its turn, then its offset from the human's wrist
constexpr double kLargestOffset = 0.03;  // m, of the roots of two hands that lie alike

using Vectors = Eigen::Matrix<double, 3, kVectors>;

/// Vectors from the wrist to the tips, then to the middle joints, in the palm's frame.
Vectors human_vectors(const HandKeypoints& human, const Matrix3d& R_world_palm, double scale) {
  Vectors result;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    const auto f = static_cast<FingerName>(finger);
    result.col(finger) = human.col(learning::keypoint(f, 3)) - human.col(0);
    result.col(hand::kShadowFingers + finger) = human.col(learning::keypoint(f, 1)) - human.col(0);
  }
  return scale * R_world_palm.transpose() * result;
}

struct OptimizerDeleter {
  void operator()(nlopt_opt optimizer) const { nlopt_destroy(optimizer); }
};
using Optimizer = std::unique_ptr<std::remove_pointer_t<nlopt_opt>, OptimizerDeleter>;

}  // namespace

RetargetPoints adroit_points() {
  return {{"S_thtip", "S_fftip", "S_mftip", "S_rftip", "S_lftip"},
          {"thmiddle", "ffmiddle", "mfmiddle", "rfmiddle", "lfmiddle"},
          {"ffknuckle", "mfknuckle", "lfknuckle"}};
}

/// The objective of one frame (eq. 7.8) over the joints and the root's turn w: the robot's vectors
/// in the human palm's frame are exp(w) R_palm_root p_root.
struct Retargeter::Problem {
  hand::PointKinematics& hand;
  const std::vector<HandPoint>& points;
  Matrix3d R_palm_root;
  Vectors wanted;
  VectorXd before;
  double alpha;

  double evaluate(const VectorXd& x, double* gradient) const {
    const Eigen::Index n = x.size() - kRootCoordinates;
    const auto robot = hand.evaluate(x.head(n), points);
    const Vector3d w = x.segment<3>(n);
    const Matrix3d R = exp_so3(w) * R_palm_root;
    const Vectors error = (R * robot.positions - wanted).colwise() + x.tail<3>();
    const VectorXd change = x - before;
    if (gradient) {
      VectorXd g = 2 * alpha * change;
      for (Eigen::Index i = 0; i < kVectors; ++i) {
        const Vector3d back = R.transpose() * error.col(i);
        g.head(n) += 2 * robot.jacobian.middleRows<3>(3 * i).transpose() * back;
        g.segment<3>(n) +=
            2 * left_jacobian(w).transpose() * (R * robot.positions.col(i)).cross(error.col(i));
        g.tail<3>() += 2 * error.col(i);
      }
      VectorXd::Map(gradient, x.size()) = g;
    }
    return error.squaredNorm() + alpha * change.squaredNorm();
  }

  /// How exp(w) turns when w changes: exp(w + d) = exp(J d) exp(w).
  static Matrix3d left_jacobian(const Vector3d& w) {
    const double angle = w.norm();
    if (angle < 1e-6) return Matrix3d::Identity() + 0.5 * skew(w);
    const Matrix3d k = skew(w / angle);
    return Matrix3d::Identity() + (1 - std::cos(angle)) / angle * k +
           (1 - std::sin(angle) / angle) * k * k;
  }

  static double callback(unsigned n, const double* x, double* gradient, void* self) {
    return static_cast<const Problem*>(self)->evaluate(VectorXd::Map(x, n), gradient);
  }
};

Retargeter::Retargeter(std::unique_ptr<hand::PointKinematics> hand, const RetargetPoints& points,
                       const RetargetOptions& options)
    : hand_(std::move(hand)), options_(options) {
  for (const auto& tip : points.tips) {
    points_.push_back(hand_->point(tip));
    const double share = hand_->share_of_link(points_.back());
    if (share < kMinTip) {
      throw BadInput(fmt::format(
          "the fingertip '{}' lies at {:.0f} % of its link, not at the end: name a site there", tip,
          100 * share));
    }
  }
  for (const auto& middle : points.middles) points_.push_back(hand_->point(middle));
  for (const auto& knuckle : points.knuckles) knuckles_.push_back(hand_->point(knuckle));
  const VectorXd rest =
      VectorXd::Zero(hand_->lower().size()).cwiseMax(hand_->lower()).cwiseMin(hand_->upper());
  const auto at_rest = hand_->evaluate(rest, knuckles_).positions;
  R_root_palm_ =
      learning::palm_frame(Vector3d::Zero(), at_rest.col(0), at_rest.col(1), at_rest.col(2));
  palm_length_ = at_rest.col(1).norm();
}

void Retargeter::solve(const HandKeypoints& human, double alpha, double largest_step) {
  const Eigen::Index n = state_.size(), joints = n - kRootCoordinates;
  Problem problem{*hand_,
                  points_,
                  R_root_palm_.transpose(),
                  human_vectors(human, learning::palm_frame(human), scale_),
                  state_,
                  alpha};
  VectorXd lower(n), upper(n);
  const double room = started_ ? 0 : kLargestOffset;
  lower << (state_.head(joints).array() - largest_step).matrix().cwiseMax(hand_->lower()),
      Vector3d::Constant(-kLargestTurn), state_.tail<3>() - Vector3d::Constant(room);
  upper << (state_.head(joints).array() + largest_step).matrix().cwiseMin(hand_->upper()),
      Vector3d::Constant(kLargestTurn), state_.tail<3>() + Vector3d::Constant(room);
  const Optimizer optimizer(nlopt_create(NLOPT_LD_SLSQP, static_cast<unsigned>(n)));
  nlopt_set_min_objective(optimizer.get(), Problem::callback, &problem);
  nlopt_set_lower_bounds(optimizer.get(), lower.data());
  nlopt_set_upper_bounds(optimizer.get(), upper.data());
  nlopt_set_maxeval(optimizer.get(), options_.evaluations);
  nlopt_set_ftol_rel(optimizer.get(), options_.tolerance);
  double value = 0;
  VectorXd x = state_;
  // A failed line search leaves the best point so far in x, which is as good as can be had.
  nlopt_optimize(optimizer.get(), x.data(), &value);
  if (x.allFinite()) state_ = x.cwiseMax(lower).cwiseMin(upper);
}

void Retargeter::start(const HandKeypoints& human) {
  const Vector3d palm = human.col(learning::keypoint(FingerName::middle, 0)) - human.col(0);
  scale_ = options_.scale > 0 ? options_.scale : palm_length_ / palm.norm();
  state_ = VectorXd::Zero(hand_->lower().size() + kRootCoordinates);
  state_.head(hand_->lower().size()) = 0.5 * (hand_->lower() + hand_->upper());
  for (int i = 0; i < kFirstSolves; ++i) solve(human, options_.alpha, kFirstStep);
  started_ = true;
}

RetargetedFrame Retargeter::next(const HandKeypoints& human) {
  if (!human.allFinite()) throw BadInput("a hand's keypoints are not finite");
  if (!started_) start(human);
  solve(human, options_.alpha, options_.largest_step);
  const Matrix3d R_world_palm = learning::palm_frame(human);
  const Eigen::Index n = hand_->lower().size();
  const Matrix3d R = exp_so3(state_.segment<3>(n)) * R_root_palm_.transpose();
  const Vectors robot = R * hand_->evaluate(state_.head(n), points_).positions;
  const Vectors error =
      (robot.colwise() + state_.tail<3>()) - human_vectors(human, R_world_palm, scale_);
  RetargetedFrame frame;
  frame.joints = state_.head(n);
  frame.tip_error = error.leftCols<hand::kShadowFingers>().colwise().norm().mean();
  frame.middle_error = error.rightCols<hand::kShadowFingers>().colwise().norm().mean();
  Vector3d center = Vector3d::Zero();
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    center +=
        human.col(learning::keypoint(static_cast<FingerName>(finger), 3)) / hand::kShadowFingers;
  }
  frame.T_world_root.linear() = R_world_palm * R;
  frame.T_world_root.translation() =
      center - R_world_palm * robot.leftCols<hand::kShadowFingers>().rowwise().mean();
  return frame;
}

}  // namespace palpate::learning
