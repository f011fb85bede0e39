// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace palpate::planning {

/// A box that stands fast in the world.
struct FixtureBox {
  Eigen::Isometry3d T_world_box = Eigen::Isometry3d::Identity();  ///< of its centre
  Eigen::Vector3d half_extents = Eigen::Vector3d::Zero();         ///< m
};

/// What stands fast on the table, its shape and place known to all: a slot or a peg, made of boxes.
using Fixture = std::vector<FixtureBox>;

}  // namespace palpate::planning
