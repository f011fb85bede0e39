// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/place.hpp"

namespace palpate::skills {

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

}  // namespace palpate::skills
