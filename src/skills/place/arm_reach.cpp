// SPDX-License-Identifier: Apache-2.0
#include "skills/place/arm_reach.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "palpate/planning/arm_planner.hpp"

namespace palpate::skills {

std::string arm_obstacle(const Executor& robot, const PlaceGoal& goal) {
  std::string obstacle = robot.path_to({goal.above, goal.mount}).obstacle;
  if (obstacle.empty()) return obstacle;
  const auto arm = robot.arm_start();
  return arm ? planning::arm_obstacle(*arm, path_down(goal)) : obstacle;
}

bool releases(const Executor& robot, const hand::MountPosition& mount, double rise) {
  constexpr double kFullTurn = 2 * std::numbers::pi;
  return std::ranges::any_of(std::array{0.0, kFullTurn, -kFullTurn}, [&](double turn) {
    PlaceGoal goal;
    goal.mount = mount;
    goal.mount.ypr.x() += turn;
    goal.above = goal.mount;
    goal.above.xyz.z() += rise;
    return arm_obstacle(robot, goal).empty();
  });
}

}  // namespace palpate::skills
