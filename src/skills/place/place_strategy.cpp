// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "palpate/core/error.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::skills {
namespace {

constexpr std::array<PlaceStrategy, 4> kStrategies = {
    PlaceStrategy::automatic, PlaceStrategy::wrist, PlaceStrategy::fingers, PlaceStrategy::regrasp};

}  // namespace

std::string_view to_string(PlaceStrategy strategy) {
  switch (strategy) {
    case PlaceStrategy::automatic:
      return "auto";
    case PlaceStrategy::wrist:
      return "wrist";
    case PlaceStrategy::fingers:
      return "fingers";
    case PlaceStrategy::regrasp:
      return "regrasp";
  }
  return "";
}

PlaceStrategy place_strategy(const PlaceOptions& options) {
  for (const PlaceStrategy strategy : kStrategies) {
    if (options.strategy == to_string(strategy)) return strategy;
  }
  throw BadInput(
      fmt::format("place.strategy = {:?}: it is \"auto\", \"wrist\", \"fingers\" or \"regrasp\"",
                  options.strategy));
}

bool was_put_back(PlaceStatus status) {
  return status == PlaceStatus::ambiguous || status == PlaceStatus::unreachable ||
         status == PlaceStatus::refused || status == PlaceStatus::slipped;
}

std::string_view to_string(PlaceStatus status) {
  switch (status) {
    case PlaceStatus::placed:
      return "placed";
    case PlaceStatus::ambiguous:
      return "ambiguous";
    case PlaceStatus::unreachable:
      return "unreachable";
    case PlaceStatus::refused:
      return "refused";
    case PlaceStatus::slipped:
      return "slipped";
    case PlaceStatus::lost:
      return "lost";
    case PlaceStatus::stuck:
      return "stuck";
    case PlaceStatus::missing:
      return "missing";
    case PlaceStatus::under_way:
      return "under_way";
    case PlaceStatus::stopped:
      return "stopped";
  }
  return "";
}

PickOptions firm_enough(const PickOptions& pick_options, const PlaceTarget& target,
                        const PlaceOptions& options) {
  PickOptions firm = pick_options;
  if (target.kind == PlaceTarget::Kind::pose) {
    firm.grasp.press_per_weight = std::max(firm.grasp.press_per_weight, options.turn_press);
  }
  return firm;
}

}  // namespace palpate::skills
