// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "palpate/hand/shadow.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"

namespace palpate::localization {

/// How the open hand comes: along `direction` towards `target`, turned by `roll` about it.
struct Approach {
  Eigen::Vector3d direction, target;
  double roll;
};

/// Closes the Shadow hand kinematically around an object that does not move.
class KinematicGrasp {
 public:
  KinematicGrasp(const geometry::ObjectModel& model, const geometry::MeshQuery& mesh,
                 const hand::Description& hand, const Eigen::Isometry3d& T_world_object,
                 bool on_table);

  /// The grasp, without contacts where the hand meets nothing.
  SceneGrasp operator()(const Approach& approach, double false_share, RandomStream& random) const;

 private:
  enum class Stage { closing, curling, stopped };
  struct Finger {
    double base = 0, curl = 0.15;  // rad, of the knuckle and of the joints beyond
    Stage stage = Stage::closing;
    std::optional<double> stopped_at;  // share of the way at which something else is met
    bool met_other = false;
  };
  using Fingers = std::array<Finger, hand::kShadowFingers>;
  struct Posture {
    Fingers fingers;
    std::array<double, hand::kShadowFingers> spread{};
    Eigen::Isometry3d T_world_palm;
  };

  std::vector<FreeSphere> balls(const Posture& posture) const;
  double gap(const FreeSphere& ball) const;
  bool approached(const Approach& approach, Posture& posture, RandomStream& random) const;
  void step(Posture& posture, int tick) const;
  void stop_at_contact(Posture& posture, const Posture& before, std::size_t finger) const;
  std::optional<tactile::Contact> tip_contact(const std::vector<FreeSphere>& balls,
                                              std::size_t finger) const;
  bool is_tip(std::size_t ball, std::size_t finger) const;
  FreeSphere tip_ball(const std::vector<FreeSphere>& balls, std::size_t finger) const;

  const geometry::ObjectModel& model_;
  const geometry::MeshQuery& mesh_;
  const hand::Description& hand_;
  Eigen::Isometry3d T_object_world_;
  Eigen::AlignedBox3d box_;
  bool on_table_;
  std::vector<int> finger_of_;  // of each ball; -1: the palm
};

}  // namespace palpate::localization
