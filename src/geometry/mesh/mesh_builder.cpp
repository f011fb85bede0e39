// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/mesh_builder.hpp"

#include <fmt/format.h>

#include "geometry/mesh/polygon.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::geometry {

void bad_file(std::string_view file, std::string_view what) {
  throw BadInput(fmt::format("{}: {}", file, what));
}

void MeshBuilder::add_vertex(const Eigen::Vector3d& position) {
  if (!position.allFinite() || position.cwiseAbs().maxCoeff() > kMaxCoordinate) {
    bad_file(file_, fmt::format("vertex {} is ({}, {}, {})", vertices(), position.x(), position.y(),
                                position.z()));
  }
  mesh_.vertices.push_back(position);
}

void MeshBuilder::add_face(std::span<const std::int64_t> corners) {
  if (corners.size() < 3 || corners.size() > kMaxCorners) {
    bad_file(file_, fmt::format("face {} has {} corners, not 3..{}", faces(), corners.size(),
                                kMaxCorners));
  }
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  face_ends_.push_back(corners_.size());
}

void MeshBuilder::triangulate(std::size_t face, std::span<const std::int64_t> corners) {
  std::vector<int> loop;
  for (const std::int64_t corner : corners) {
    if (corner < 0 || corner >= static_cast<std::int64_t>(vertices())) {
      bad_file(file_, fmt::format("face {} names vertex {}, but there are {} (counted from 0)",
                                  face, corner, vertices()));
    }
    loop.push_back(static_cast<int>(corner));
  }
  const auto triangles = clip_ears(mesh_.vertices, loop);
  if (triangles) {
    mesh_.triangles.insert(mesh_.triangles.end(), triangles->begin(), triangles->end());
    return;
  }
  for (std::size_t k = 2; k < loop.size(); ++k) {  // a polygon that crosses itself: any cut will do
    mesh_.triangles.push_back({loop[0], loop[k - 1], loop[k]});
  }
}

TriangleMesh MeshBuilder::finish() && {
  if (face_ends_.empty()) {
    bad_file(file_, vertices() == 0 ? "has no faces"
                                    : fmt::format("has {} vertices but no faces", vertices()));
  }
  std::size_t begin = 0;
  for (std::size_t face = 0; face < faces(); ++face) {
    triangulate(face, std::span(corners_).subspan(begin, face_ends_[face] - begin));
    begin = face_ends_[face];
  }
  return std::move(mesh_);
}

}  // namespace palpate::geometry
