// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "palpate/hand/hand.hpp"
#include "palpate/tactile/biotac/fingers.hpp"

namespace palpate::tactile {

/// A hand whose contacts are inferred from the channels of its fingertips' BioTacs, and from
/// nothing else.
class BiotacHand : public hand::Hand {
 public:
  /// Keeps a reference: the hand must outlive this. @param model  of the hand, for the sensors'
  /// places
  BiotacHand(hand::Hand& hand, const hand::Description& model,
             std::shared_ptr<const tactile::BiotacInverse> inverse);

  /// @throws BadInput if the hand's readings hold no channels
  hand::HandReading step(const hand::HandCommand& command) override;
  std::optional<hand::HandReading> sense() override;
  [[nodiscard]] hand::PathFeasibility check_path(
      std::span<const hand::MountPosition> way) const override {
    return hand_.check_path(way);
  }
  [[nodiscard]] hand::MountLimits mount_limits() const override { return hand_.mount_limits(); }
  [[nodiscard]] hand::ArmPosture arm_posture() const override { return hand_.arm_posture(); }

 private:
  hand::Hand& hand_;
  tactile::BiotacFingers fingers_;
};

/// The shipped inverse of the simulated BioTac. @throws BadInput if it is missing or damaged
std::shared_ptr<const tactile::BiotacInverse> shipped_biotac_inverse();

}  // namespace palpate::tactile
