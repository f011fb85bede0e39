// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/contact_hand.hpp"

#include <utility>

#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"

namespace palpate::tactile {

BiotacHand::BiotacHand(hand::Hand& hand, const hand::Description& model,
                       std::shared_ptr<const tactile::BiotacInverse> inverse)
    : hand_(hand), fingers_(model, std::move(inverse)) {}

hand::HandReading BiotacHand::step(const hand::HandCommand& command) {
  hand::HandReading reading = hand_.step(command);
  fingers_.infer_contacts(reading);
  return reading;
}

std::optional<hand::HandReading> BiotacHand::sense() {
  std::optional<hand::HandReading> reading = hand_.sense();
  if (reading) fingers_.infer_contacts(*reading);
  return reading;
}

std::shared_ptr<const tactile::BiotacInverse> shipped_biotac_inverse() {
  const auto path = asset("models/biotac_inverse.model");
  return std::make_shared<const tactile::BiotacInverse>(
      tactile::BiotacInverse::parse(read_file(path), path.string()));
}

}  // namespace palpate::tactile
