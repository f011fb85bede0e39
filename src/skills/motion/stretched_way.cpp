// SPDX-License-Identifier: Apache-2.0
#include "skills/motion/stretched_way.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::skills {

std::vector<hand::HandCommand> stretched(const hand::HandCommand& from,
                                         std::span<const hand::HandCommand> way,
                                         std::size_t ticks) {
  if (way.empty() || ticks == way.size()) return {way.begin(), way.end()};
  std::vector<hand::HandCommand> result;
  result.reserve(ticks);
  for (std::size_t i = 1; i <= ticks; ++i) {
    const double t = static_cast<double>(i * way.size()) / static_cast<double>(ticks);
    const auto after = std::min(static_cast<std::size_t>(std::ceil(t)), way.size()) - 1;
    const hand::HandCommand& a = after == 0 ? from : way[after - 1];
    const hand::HandCommand& b = way[after];
    const double share = t - static_cast<double>(after);
    result.push_back({.positions = a.positions + share * (b.positions - a.positions),
                      .mount = between(a.mount, b.mount, share)});
  }
  if (ticks > 0) result.back() = way.back();
  return result;
}

}  // namespace palpate::skills
