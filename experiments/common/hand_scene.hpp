// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::experiment {

/// How far an object went between two moments.
struct Motion {
  double way = 0;   ///< m, of the centroid
  double turn = 0;  ///< rad
};

Motion between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// A simulated hand at work on an object, with the truth of every tick, from the start that a pick
/// of that seed has.
class HandScene {
 public:
  HandScene(const geometry::KnownObject& object, std::uint64_t seed);

  skills::Executor& robot() { return robot_; }
  [[nodiscard]] std::size_t now() const { return truths_.size() - 1; }
  [[nodiscard]] double lowest() const { return world_.truth().lowest_point; }
  [[nodiscard]] const Eigen::Isometry3d& in_world(std::size_t tick) const { return truths_[tick]; }
  [[nodiscard]] Eigen::Isometry3d in_hand(std::size_t tick) const;

 private:
  skills::Executor make_robot(const geometry::KnownObject& object, std::uint64_t seed);

  simulation::World world_;
  std::vector<Eigen::Isometry3d> truths_;  // T_world_object, one a reading
  skills::Executor robot_;
};

}  // namespace palpate::experiment
