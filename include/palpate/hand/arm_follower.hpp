// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "palpate/hand/arm.hpp"
#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// Converts commands for the mount of a hand into commands for an arm's joints, tick by tick: by
/// inverse kinematics from the joints of the tick before, within the joints' ranges, speeds and
/// accelerations. The one place where these limits are applied.
class ArmFollower {
 public:
  explicit ArmFollower(ArmDescription arm) : arm_(std::move(arm)) {}

  [[nodiscard]] const ArmDescription& arm() const { return arm_; }
  /// The joints as last commanded; none before reset().
  [[nodiscard]] const ArmVector& joints() const { return joints_; }

  /// Those for the last pose of the mount, to which they may still be on the way.
  [[nodiscard]] ArmPosture posture() const {
    return {&arm_, {wanted_.data(), wanted_.data() + wanted_.size()}};
  }

  /// Starts at a pose of the mount, in the branch of the inverse kinematics from which most of the
  /// tour can be followed. It need not be the branch in which the arm stands: bring it to these
  /// joints, slowly, before the first follow().
  /// @throws BadInput if the arm cannot hold the mount there
  const ArmVector& reset(const Eigen::Isometry3d& T_world_mount,
                         std::span<const MountPosition> tour = {});

  /// The joints for the next tick. Where the arm cannot follow, it comes as near as it can.
  /// @throws std::logic_error before reset()
  const ArmVector& follow(const Eigen::Isometry3d& T_world_mount);

  /// Whether the arm can follow a way that starts where it is commanded to be, one position a tick.
  /// @throws std::logic_error before reset()
  [[nodiscard]] PathFeasibility check_path(std::span<const MountPosition> way) const;

 private:
  void require_reset() const;
  [[nodiscard]] std::size_t followed(ArmVector joints, std::span<const MountPosition> tour) const;

  ArmDescription arm_;
  ArmVector wanted_;           // for the mount's pose
  ArmVector joints_, speeds_;  // as commanded
};

/// A tour through the attitudes in which skills use a hand: each from all sides, above the
/// workspace's middle and above the table.
std::vector<MountPosition> working_tour(const Description& hand);

}  // namespace palpate::hand
