// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "palpate/tasks/relocate/policies/policy.hpp"

namespace palpate::relocate {

/// How many fingers' joints a policy uses as a memory of where the base was.
inline constexpr int kMemoryJoints = 3;

/// What a structured policy is made of. Lengths m, forces N; turns and postures are actions.
struct StructuredParameters {
  using Posture = Eigen::Matrix<double, 24, 1>;  ///< wrist and fingers

  Eigen::Vector3d approach_offset{0, -0.08, 0.05};  ///< palm from object, wanted from afar
  Eigen::Vector3d grasp_offset{0, 0, 0.015};        ///< palm from object, wanted for the grasp
  Eigen::Vector3d approach_turn = Eigen::Vector3d::Zero();
  Eigen::Vector3d grasp_turn = Eigen::Vector3d::Zero();
  Eigen::Vector3d carry_turn = Eigen::Vector3d::Zero();
  Posture open = Posture::Zero();
  Posture closed = Posture::Zero();
  Eigen::Vector2d descend{0.11, 0.03};  ///< horizontal distance where it is over, and width
  Eigen::Vector2d close{0.12, 0.01};    ///< distance at which to close, and width
  Eigen::Vector2d latch{8, 0.3};        ///< how a flexed hand (1/rad, rad) keeps closing
  /// How much more an error along x counts than one along y, for descending and for closing: the
  /// hand stays behind the object, and open, until it stands in line with it.
  Eigen::Vector2d align{3, 3};
  Eigen::Vector2d carry_flexion{0.8, 0.08};    ///< flexion from which to carry, and width, rad
  Eigen::Vector2d carry_distance{0.10, 0.01};  ///< distance up to which to carry, and width
  Eigen::Vector2d reach_gains{1200, 120};      ///< N/m, N s/m
  Eigen::Vector2d carry_gains{1200, 120};      ///< N/m, N s/m
  Eigen::Vector3d reach_force{0, 48, 0};       ///< that holds the empty hand, along the base's axes
  Eigen::Vector3d carry_force{0, 51, 0};       ///< that holds hand and object
  Eigen::Vector3d target_offset = Eigen::Vector3d::Zero();  ///< of the object from the target
  Eigen::Vector2d limits{0.4, 0.4};            ///< of each error, while reaching and while carrying
  Eigen::Vector3d memory_gain{4, 9, 3};        ///< of the remembered base positions, 1/m
  Eigen::Vector3d memory_center{0, 0.1, 0.1};  ///< what a memory of 0 means, m
};

/// How wide to search around each parameter at first.
StructuredParameters structured_spread();

/// Starting point of a search: an open hand above the object that closes by half.
StructuredParameters structured_start();

/// The same with ring and little finger stretched: their joints can only remember where the base
/// was while they touch nothing.
StructuredParameters with_free_memory(StructuredParameters parameters);

/// All parameters in one vector, and back. @throws BadInput for another size
Eigen::VectorXd flatten(const StructuredParameters& parameters);
StructuredParameters unflatten(const Eigen::VectorXd& values);

/// Reach, close, transport: three controllers of the base's position and hand's posture, blended by
/// smooth gates on how near and how flexed the hand is. One frame decides; there is no clock.
///
/// The base is underdamped, so a velocity is needed to stop it. It is read from the joints, or, for
/// a policy on the observations alone, a network estimates it from one frame: some finger joints
/// that the grasp does not need are commanded to copy the base's position, and how far they lag
/// behind shows its velocity.
class StructuredPolicy : public Policy {
 public:
  /// Inputs of the velocity observer: observation, gates, lags of the memory and their products.
  static constexpr int kFeatures = kRelocateObservations + 4 + 2 * kMemoryJoints;

  struct Observer {
    numerics::Mlp network;                                            ///< kFeatures -> ... -> 3
    Eigen::VectorXd shift, scale;                                     ///< of its inputs
    Eigen::Vector3d velocity(const Eigen::VectorXd& features) const;  ///< m/s
  };

  /// @param center, half_range  of the actions, as RelocateModel gives them
  /// @param with_memory         whether the memory joints are used as such
  /// @param observer            none: the velocity is read from the joints
  StructuredPolicy(const StructuredParameters& parameters, const RelocateAction& center,
                   const RelocateAction& half_range, bool with_memory,
                   std::optional<Observer> observer = {});

  RelocateAction act(const PolicyInput& input) const override;
  std::vector<std::string> observes() const override;
  PolicyRecord record() const override;

  Eigen::VectorXd features(const RelocateObservation& observation) const;
  const StructuredParameters& parameters() const { return parameters_; }
  const std::optional<Observer>& observer() const { return observer_; }
  bool with_memory() const { return with_memory_; }

  /// The same policy with other parameters and another observer.
  StructuredPolicy variant(const StructuredParameters& parameters,
                           const std::optional<Observer>& observer) const {
    return {parameters, center_, half_range_, with_memory_, observer};
  }

 private:
  struct Gates;
  Gates gates(const RelocateObservation& o) const;
  Eigen::Vector3d memory(const RelocateObservation& o) const;
  Eigen::VectorXd features(const RelocateObservation& o, const Gates& gates) const;
  Eigen::Vector3d base_force(const RelocateObservation& o, const Gates& gates,
                             const Eigen::Vector3d& velocity) const;

  StructuredParameters parameters_;
  RelocateAction center_, half_range_;
  bool with_memory_;
  std::optional<Observer> observer_;
};

/// The policy that a record of kind "structured" describes. @throws BadInput as policy_from
std::unique_ptr<Policy> structured_policy_from(const PolicyRecord& record);

}  // namespace palpate::relocate
