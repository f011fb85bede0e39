// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place_strategy.hpp"

#include <fmt/format.h>

#include <array>

#include "palpate/core/error.hpp"

namespace palpate::skills {
namespace {

constexpr std::array<PlaceStrategy, 4> kAskedFor = {PlaceStrategy::automatic, PlaceStrategy::wrist,
                                                    PlaceStrategy::fingers, PlaceStrategy::regrasp};

}  // namespace

std::string_view to_string(PlaceStrategy strategy) {
  switch (strategy) {
    case PlaceStrategy::none:
      return "none";
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

PlaceStrategy place_strategy(std::string_view word) {
  for (const PlaceStrategy strategy : kAskedFor) {
    if (word == to_string(strategy)) return strategy;
  }
  throw BadInput(fmt::format(
      "place.strategy = {:?}: it is \"auto\", \"wrist\", \"fingers\" or \"regrasp\"", word));
}

}  // namespace palpate::skills
