// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "palpate/core/se3.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::localization {

/// A ball known to be free of the object: a part of the hand, at a place it has been.
struct FreeSphere {
  Eigen::Vector3d center;  ///< m
  double radius = 0;       ///< m
};

/// The object rests (nearly) on a table in one of its stable poses, its position roughly known.
struct TableSupport {
  Eigen::Isometry3d T_frame_table;  ///< table frame: z up, z = 0 the surface; x, y the rough place
  std::vector<double>
      stable_pose_weights;      ///< one per KnownObject::stable_poses; empty: their probabilities
  double tilt_sigma = 0.02;     ///< rad
  double height_sigma = 0.001;  ///< m
  /// m by which the surface on which it rests is off: it leans (geometry::RestingSlack) and stands
  /// higher or lower by that. Evidence::surface_sigma comes on top.
  double surface_sigma = 0;
  double centroid_sigma = 0;  ///< m per axis, error of the centre of mass: the object leans by it
  double half_width = 0.02;   ///< object's centroid within +- of the origin in x and y, m
  double edge_sigma = 0.002;  ///< softness of that bound, m
};

/// What was known of the pose before, as a mixture of normal distributions, heaviest first.
struct PosePrior {
  struct Component {
    Eigen::Isometry3d T_frame_object;
    /// Sums to <= 1 over the components; the rest, at least a fifth, is the share of the search
    /// that starts `elsewhere`: where the table or else single contacts let the object be.
    double weight;
    /// Of [rotation; translation] (rad, m), frame's axes, rotation about the object's origin:
    /// R = exp(w) R0, t = t0 + v.
    Matrix6d covariance;
  };
  std::vector<Component> components;
  /// Density relative to the highest component's peak that every pose keeps, so that touch can
  /// overrule the prior. It holds everywhere: where the components are narrow, 1e-3 outweighs them
  /// until several contacts agree with them; spread_elsewhere() sets it by a probability. Without
  /// contacts it is not used: the modes then hold what the components' weights sum to.
  double floor = 1e-3;
};

/// Contacts displaced alike by an error of the hand's geometry: normal, the same along the axes of
/// the offset's own frame. It is integrated out instead of being taken for noise of each contact.
struct CommonModeBias {
  struct Member {
    std::size_t contact;  ///< index into Evidence::contacts
    Eigen::Matrix3d R_frame_offset = Eigen::Matrix3d::Identity();
  };
  double sigma = 0.001;  ///< per axis, m
  std::vector<Member> members;
};

/// The object is at rest in the hand: pushes and weight have no moment. That determines where the
/// centre of mass is across the weight.
struct ForceBalance {
  /// What one contact does to the object.
  struct Push {
    Eigen::Vector3d p;  ///< point, m
    Eigen::Vector3d n;  ///< outward unit normal of the object
    Eigen::Vector3d f;  ///< force on the object, N
  };
  std::vector<Push> pushes;    ///< of all that touches it, at least one
  Eigen::Vector3d weight;      ///< of the object, N
  double point_sigma = 0.001;  ///< m, per push and axis
  double force_sigma = 0.02;   ///< N, per push and axis
  double torsional_friction_radius =
      0.003;  ///< m: moment about a push's normal that is not sensed, by its force
  double other_support_prior = 0.05;  ///< that something else holds the object, too
};

/// The held object was let down until it touched a plane, with whatever part of it is lowest.
struct PlaneContact {
  Eigen::Vector3d normal;  ///< of the plane, unit, to the object's side
  double height = 0;       ///< of the plane over the frame's origin, along the normal, m
  double sigma = 0.001;    ///< of that, m
};

/// All that is measured of the object by touch at one instant, in one frame.
struct Evidence {
  std::vector<tactile::Contact> contacts;
  std::vector<CommonModeBias> offsets;  ///< a contact is in one of them at most
  double false_contact_share = 0.02;    ///< prior share of contacts with something else
  /// m^2 of surface over which a contact may lie, the same for all objects that are compared by
  /// this evidence: the hand, not the object, decides where it touches. None: the object's own.
  std::optional<double> contact_area;
  double surface_sigma = 0.0003;  ///< m by which the mesh's surface is off the object's
  /// Prior probability that the noise of all contacts is not as stated, but half to twice as much.
  /// Of each contact an eighth of that is the probability that its normal alone is three times as
  /// noisy.
  double noise_scale_prior = 0.4;
  /// Prior probability that the object is up to 3 % larger or smaller than its mesh. Not looked at
  /// where contacts share offsets.
  double size_prior = 0.25;
  std::vector<FreeSphere> free_space;
  double penetration_sigma = 0.0015;  ///< m
  std::vector<PlaneContact> planes;
  std::optional<ForceBalance> balance;
  std::optional<TableSupport> table;
  std::optional<PosePrior> prior;  ///< instead of the table or together with it
};

}  // namespace palpate::localization
