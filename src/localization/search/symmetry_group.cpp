// SPDX-License-Identifier: Apache-2.0
#include "localization/search/symmetry_group.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::localization {
namespace {

constexpr std::size_t kContinuous = 100;  // elements; the icosahedron's group has 60
constexpr double kKept = 1e-4;            // 1 - cosine of how far a line that is kept may move
constexpr double kIdentity = 1e-9;        // of 1 - |w|

std::vector<Eigen::Quaterniond> quaternions(const std::vector<Eigen::Matrix3d>& rotations) {
  std::vector<Eigen::Quaterniond> result;
  for (const Eigen::Matrix3d& R : rotations) result.emplace_back(R);
  return result;
}

/// The axis of the smallest turn that is none.
Eigen::Vector3d axis_of_smallest(const std::vector<Eigen::Quaterniond>& rotations) {
  double most = -1;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  for (const Eigen::Quaterniond& q : rotations) {
    const double w = std::abs(q.w());
    if (w > 1 - kIdentity || w <= most) continue;
    most = w;
    axis = q.vec().normalized();
  }
  return axis;
}

/// The turn about a unit axis in the rotation's decomposition into swing and turn.
Eigen::Quaterniond turn_about(const Eigen::Vector3d& axis, const Eigen::Quaterniond& rotation) {
  const Eigen::Vector2d part(rotation.w(), rotation.vec().dot(axis));
  if (part.norm() < kIdentity) return Eigen::Quaterniond::Identity();  // all are as far
  const Eigen::Vector2d unit = part.normalized();
  Eigen::Quaterniond turn;
  turn.w() = unit[0];
  turn.vec() = unit[1] * axis;
  return turn;
}

Eigen::Quaterniond half_turn(const Eigen::Vector3d& axis) {
  return {0, axis.x(), axis.y(), axis.z()};
}

}  // namespace

SymmetryGroup::SymmetryGroup(std::vector<Eigen::Quaterniond> rotations)
    : rotations_(std::move(rotations)) {
  if (rotations_.empty()) rotations_.push_back(Eigen::Quaterniond::Identity());
  if (rotations_.size() > kContinuous) recognize_continuous();
}

SymmetryGroup::SymmetryGroup(const std::vector<Eigen::Matrix3d>& rotations)
    : SymmetryGroup(quaternions(rotations)) {}

void SymmetryGroup::recognize_continuous() {
  const Eigen::Vector3d axis = axis_of_smallest(rotations_);
  const auto moves_line = [&](const Eigen::Quaterniond& q) {
    return std::abs(axis.dot(q * axis)) < 1 - kKept;
  };
  all_ = std::ranges::any_of(rotations_, moves_line);
  if (all_) return;
  line_ = axis;
  const auto flip = std::ranges::find_if(
      rotations_, [&](const Eigen::Quaterniond& q) { return axis.dot(q * axis) < 0; });
  if (flip != rotations_.end()) flip_ = *flip;
  list_turns();
}

void SymmetryGroup::list_turns() {
  std::vector<Turns> lists = {{half_turn(*line_), Eigen::Quaterniond::Identity(), {}}};
  if (flip_) lists.push_back({half_turn(*line_), *flip_, {}});
  for (std::size_t i = 0; i < rotations_.size(); ++i) {
    const Eigen::Quaterniond& q = rotations_[i];
    Turns& list = lists[line_->dot(q * *line_) < 0 ? 1 : 0];
    const Eigen::Quaterniond rest = q * list.first.conjugate();
    const Eigen::Quaterniond turn = turn_about(*line_, rest);
    if (std::abs(turn.dot(rest)) < 1 - kIdentity) return;  // it tilts the line
    const double angle = 2 * std::atan2(turn.vec().dot(*line_), turn.w());
    list.turns.push_back({i, std::cos(angle), std::sin(angle)});
  }
  turns_ = std::move(lists);
}

Eigen::Quaterniond SymmetryGroup::nearest_turn(const Eigen::Quaterniond& rotation) const {
  const Eigen::Quaterniond turn = turn_about(*line_, rotation);
  if (!flip_) return turn;
  const Eigen::Quaterniond flipped = *flip_ * turn_about(*line_, flip_->conjugate() * rotation);
  return std::abs(rotation.dot(flipped)) > std::abs(rotation.dot(turn)) ? flipped : turn;
}

Eigen::Matrix3d SymmetryGroup::seen_rotations() const {
  if (all_) return Eigen::Matrix3d::Zero();
  if (line_) return Eigen::Matrix3d::Identity() - *line_ * line_->transpose();
  return Eigen::Matrix3d::Identity();
}

Eigen::Quaterniond SymmetryGroup::nearest(const Eigen::Quaterniond& rotation) const {
  if (all_) return rotation;
  if (line_) return nearest_turn(rotation);
  return *std::ranges::max_element(
      rotations_, {}, [&](const Eigen::Quaterniond& s) { return std::abs(rotation.dot(s)); });
}

}  // namespace palpate::localization
