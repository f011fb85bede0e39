// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/target.hpp"

#include <algorithm>
#include <array>

#include "palpate/core/se3.hpp"
#include "recording/note_numbers.hpp"

namespace palpate::recording {

std::optional<Eigen::Isometry3d> target_at(const std::vector<Event>& events, double time) {
  std::optional<Eigen::Isometry3d> target;
  for (const Event& event : events) {
    if (event.kind != EventKind::note || event.time > time) continue;
    const auto numbers = numbers_after(kTargetNote, event.text, kPoseNumbers);
    if (numbers.empty()) continue;
    std::array<double, kPoseNumbers> rows{};
    std::ranges::copy(numbers, rows.begin());
    target = pose_from_row_major(rows);
  }
  return target;
}

}  // namespace palpate::recording
