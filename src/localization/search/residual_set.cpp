// SPDX-License-Identifier: Apache-2.0
#include "localization/search/residual_set.hpp"

#include <algorithm>

namespace palpate::localization {
namespace {

using Poses = std::vector<PosePoint>;

/// A ball about a pose, and how many of each population only it holds.
struct Ball {
  PosePoint center;
  std::size_t chosen = 0, weighed = 0;
};

/// Balls about poses of `chosen` in their order, which are random draws, so that a dense place is
/// likely to be met early; both populations are used up.
std::vector<Ball> cover(Poses chosen, Poses& weighed, const PoseFamily::Symmetries& symmetries) {
  std::vector<Ball> balls;
  while (!chosen.empty()) {
    Ball ball{chosen.back()};
    const PoseFamily family(ball.center);
    ball.chosen = take(family, symmetries, chosen);
    ball.weighed = take(family, symmetries, weighed);
    balls.push_back(std::move(ball));
  }
  std::stable_sort(balls.begin(), balls.end(),
                   [](const Ball& a, const Ball& b) { return a.chosen > b.chosen; });
  return balls;
}

}  // namespace

double unseen_share(const Poses& poses, const Poses& others,
                    const PoseFamily::Symmetries& symmetries) {
  if (poses.empty()) return 0;
  const auto unseen = std::count_if(poses.begin(), poses.end(), [&](const PosePoint& pose) {
    const PoseFamily ball(pose);
    return std::none_of(others.begin(), others.end(),
                        [&](const PosePoint& other) { return ball.contains(other, symmetries); });
  });
  return static_cast<double>(unseen) / static_cast<double>(poses.size());
}

ResidualSet residual_set(const std::vector<Mode>& modes, const Poses& chosen_on,
                         const Poses& weighed_on, const PoseFamily::Symmetries& symmetries) {
  const double wanted = kCredible * static_cast<double>(weighed_on.size());
  Poses chosen = chosen_on, weighed = weighed_on;
  std::size_t held = 0;
  for (const Mode& mode : modes) {
    held += take(family_of(mode), symmetries, weighed);
    take(family_of(mode), symmetries, chosen);
  }
  ResidualSet rest;
  if (static_cast<double>(held) >= wanted) return rest;
  for (const Ball& ball : cover(std::move(chosen), weighed, symmetries)) {
    if (static_cast<double>(held) >= wanted) return rest;
    rest.poses.push_back(ball.center.isometry());
    held += ball.weighed;
  }
  if (static_cast<double>(held) >= wanted) return rest;
  rest.credible_mass = static_cast<double>(held) / static_cast<double>(weighed_on.size());
  Poses none;
  for (const Ball& ball : cover(std::move(weighed), none, symmetries)) {
    rest.poses.push_back(ball.center.isometry());
  }
  return rest;
}

}  // namespace palpate::localization
