// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::hand {

/// One drawn part of the hand: a mesh fixed to a link.
struct VisualPart {
  int link = 0;      ///< index into Description::links
  std::string mesh;  ///< key into HandVisuals::meshes
  Eigen::Isometry3d T_link_mesh = Eigen::Isometry3d::Identity();
  Eigen::Vector3d color = Eigen::Vector3d::Constant(0.5);  ///< rgb, 0..1
};

/// What the hand looks like. Only for drawing.
struct HandVisuals {
  std::map<std::string, geometry::TriangleMesh> meshes;
  std::vector<VisualPart> parts;
};

}  // namespace palpate::hand
