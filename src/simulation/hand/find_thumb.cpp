// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/find_thumb.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "palpate/core/error.hpp"

namespace palpate::simulation {

int find_thumb(const FingerMotion& motion) {
  std::vector<Eigen::Vector3d> ways, rays;
  for (std::size_t i = 0; i < motion.bases.size(); ++i) {
    ways.push_back((motion.bent[i] - motion.straight[i]).normalized());
    rays.push_back((motion.straight[i] - motion.bases[i]).normalized());
  }
  double least = std::numeric_limits<double>::infinity();
  int thumb = 0;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    double alike = 0;
    for (std::size_t j = 0; j < ways.size(); ++j) {
      if (j != i) alike += ways[i].dot(ways[j]) + rays[i].dot(rays[j]);
    }
    if (alike >= least) continue;
    least = alike;
    thumb = static_cast<int>(i);
  }
  return thumb;
}

int named_thumb(const hand::Description& hand, const std::string& name) {
  const auto named = std::ranges::find(hand.fingers, name, &hand::Finger::name);
  if (named != hand.fingers.end()) return static_cast<int>(named - hand.fingers.begin());
  std::vector<std::string> names;
  for (const hand::Finger& finger : hand.fingers) names.push_back(finger.name);
  throw BadInput(
      fmt::format("thumb = '{}' is none of the fingers: {}", name, fmt::join(names, ", ")));
}

}  // namespace palpate::simulation
