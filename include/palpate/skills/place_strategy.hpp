// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace palpate::skills {

/// Which way an object is brought to its target.
enum class PlaceStrategy {
  none,       ///< it is there
  automatic,  ///< in one hold, turned in the hand or grasped again where that cannot be
  wrist,      ///< in one hold, turned by the hand's mount
  fingers,    ///< in one hold, turned first by the fingers as far as they can, then by the mount
  regrasp     ///< with planned grasps, over other stable poses if need be
};
std::string_view to_string(PlaceStrategy strategy);

/// What PlaceOptions::strategy asks for: any but `none`.
/// @throws BadInput for another word
PlaceStrategy place_strategy(std::string_view word);

}  // namespace palpate::skills
