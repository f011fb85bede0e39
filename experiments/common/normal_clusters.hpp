// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <span>
#include <vector>

namespace palpate::tactile {

/// A point of contact with the outward normal sensed or estimated there.
struct NormalAt {
  Eigen::Vector3d p, n;
};

/// Contacts that belong together.
struct NormalCluster {
  Eigen::Vector3d p;  ///< centroid, m
  Eigen::Vector3d n;  ///< mean normal, unit
  std::size_t size = 0;
};

struct ClusterOptions {
  double distance = 0.01;               ///< m; thesis 5.3.3 takes 1 cm
  double angle = std::numbers::pi / 5;  ///< rad; pi: by place alone, as the thesis does
  int min = 3;                          ///< contacts that make a cluster

  template <class Visitor>
  void visit(Visitor&& v) {
    v("distance", distance, 0.0, 1.0, "m, between neighbours of one cluster");
    v("angle", angle, 0.0, std::numbers::pi, "rad, between normals of neighbours");
    v("min", min, 1, 1000000, "contacts that make a cluster");
  }
};

/// Euclidean clustering (thesis 5.3.3, there over 10 ticks): contacts nearer than `distance` whose
/// normals differ by less than `angle` are neighbours, and chains of neighbours are clusters, so
/// that two faces that meet under a fingertip stay two. Largest first, then in the order given.
/// @throws BadInput for options out of range, a contact that is not finite or a normal that is not
///         of unit length
std::vector<NormalCluster> cluster_normals(std::span<const NormalAt> contacts,
                                           const ClusterOptions& options = {});

struct FaceOptions {
  double radius = 0.1;             ///< rad, around a face's normal
  double apart = 0.6;              ///< rad, between faces
  double min_share = 0.05;         ///< of all normals, within `radius` of the face's
  double min_spread = 1.3;         ///< times their noise that the points spread over the face
  double min_concentration = 0.6;  ///< of the normals within twice `radius`, those within it

  template <class Visitor>
  void visit(Visitor&& v) {
    v("radius", radius, 0.0, 1.5, "rad, around a face's normal");
    v("apart", apart, 0.0, 3.1, "rad, between faces");
    v("min_share", min_share, 0.0, 1.0, "of all normals that makes a face");
    v("min_spread", min_spread, 0.0, 1e3, "times their noise that a face's points spread");
    v("min_concentration", min_concentration, 0.0, 1.0,
      "of the normals within twice the radius, those within it");
  }
};

/// A direction that many of a finger's normals share.
struct Face {
  Eigen::Vector3d n;  ///< unit
  double share = 0;   ///< of all normals, within FaceOptions::radius
};

/// The faces that a fingertip has met, from its contacts in the order of time: what an edge or
/// corner reports in place of a mean. The modes of the normals (by mean shift), densest first, each
/// `apart` from those before.
///
/// A tip that rests on an edge senses a direction between two faces; its points then spread along a
/// line, and across it by their noise alone. Modes whose points do not spread over an area are no
/// faces. Nor are those that thin out slowly, as on a curved surface: evenly spread, a quarter to
/// half of the normals within twice the radius are within it.
/// @throws BadInput for options out of range, a contact that is not finite or a normal that is not
///         of unit length
std::vector<Face> find_faces(std::span<const NormalAt> contacts, const FaceOptions& options = {});

}  // namespace palpate::tactile
