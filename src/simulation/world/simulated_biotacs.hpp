// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/biotac/sensor.hpp"

namespace palpate::simulation {

/// What presses on a fingertip, in its distal link's frame, without noise.
struct TipLoad {
  std::vector<hand::TipContact> on_object;
  std::vector<hand::TipContact> on_others;  ///< the table, or what stands on it
  Eigen::Isometry3d T_object_link = Eigen::Isometry3d::Identity();
};

/// The BioTacs of a simulated hand's fingertips.
class SimulatedBiotacs {
 public:
  /// Keeps a reference: the object's mesh, in its frame, must outlive this.
  SimulatedBiotacs(const geometry::MeshQuery& object, const hand::Description& hand,
                   const RandomStream& random);

  /// Back to rest at time 0, the noise again.
  void reset();

  /// The channels at the end of a tick; the skin meets the object's true surface, and a plane
  /// through each contact with something else.
  std::vector<hand::BiotacReading> step(const std::vector<TipLoad>& loads, double time);

 private:
  [[nodiscard]] tactile::SkinState press(const TipLoad& load, const Eigen::Isometry3d& mount) const;

  const geometry::MeshQuery& object_;
  std::unique_ptr<const tactile::BiotacSkin> skin_;  // which the sensors refer to
  std::vector<Eigen::Isometry3d> mounts_;
  std::vector<tactile::BiotacSensor> sensors_;
};

}  // namespace palpate::simulation
