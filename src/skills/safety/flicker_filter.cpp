// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/flicker_filter.hpp"

#include <algorithm>

namespace palpate::skills {
namespace {

constexpr double kSamePoint = 0.008;  // m between a contact's points in two readings
constexpr double kForgotten = 0.003;  // of the flashes, each reading: counted over about 3 s
constexpr double kMaxFlashes = 10;    // where a good sensor's touches begin and end

using Points = std::vector<Eigen::Vector3d>;

bool has_near(const Points& points, const Eigen::Vector3d& p) {
  return std::any_of(points.begin(), points.end(),
                     [&](const Eigen::Vector3d& other) { return (other - p).norm() < kSamePoint; });
}

}  // namespace

void FlickerFilter::filter(int finger, std::vector<hand::TipContact>& contacts) {
  Finger& state = fingers_[static_cast<std::size_t>(finger)];
  Points now;
  for (const auto& contact : contacts) now.push_back(contact.p);
  const Points &last = state.before[0], &earlier = state.before[1];
  state.flashes *= 1 - kForgotten;
  for (const auto& p : last) state.flashes += !has_near(now, p) && !has_near(earlier, p);
  state.noisy = state.noisy || state.flashes > kMaxFlashes;
  if (state.noisy) {
    std::erase_if(contacts, [&](const hand::TipContact& contact) {
      return !std::all_of(state.before.begin(), state.before.end(),
                          [&](const Points& points) { return has_near(points, contact.p); });
    });
  }
  std::move_backward(state.before.begin(), state.before.end() - 1, state.before.end());
  state.before.front() = std::move(now);
}

}  // namespace palpate::skills
