// SPDX-License-Identifier: Apache-2.0
#include "hand_scene.hpp"

#include "palpate/evaluation/trial.hpp"

namespace palpate::experiment {

Motion between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return {(b.translation() - a.translation()).norm(), rotation_distance(a.linear(), b.linear())};
}

HandScene::HandScene(const geometry::KnownObject& object, std::uint64_t seed)
    : world_(object, {}, seed), robot_(make_robot(object, seed)) {}

Eigen::Isometry3d HandScene::in_hand(std::size_t tick) const {
  return robot_.log().readings[tick].mount.pose().inverse() * truths_[tick];
}

skills::Executor HandScene::make_robot(const geometry::KnownObject& object, std::uint64_t seed) {
  world_.reset(evaluation::draw_start(object, {}, seed),
               evaluation::waiting_command(world_.hand_model()));
  const auto note = [this](const auto&, const auto&) {
    truths_.push_back(world_.truth().T_world_object);
  };
  return {world_.hand(),
          world_.hand_model(),
          evaluation::waiting_command(world_.hand_model()),
          {note, {}, {}}};
}

}  // namespace palpate::experiment
