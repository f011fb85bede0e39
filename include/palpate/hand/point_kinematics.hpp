// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace palpate::hand {

/// A point fixed to a body of a hand.
struct HandPoint {
  std::string name;  ///< of the site or body that it was asked for by
  int body = -1;
  Eigen::Vector3d p_body = Eigen::Vector3d::Zero();  ///< m
};

/// Positions of points in the root's frame, and how they change with the joints.
struct HandPoints {
  Eigen::Matrix3Xd positions;  ///< 3 x n, m
  Eigen::MatrixXd jacobian;    ///< 3n x joints, m/rad: three rows a point
};

/// Where named points of a hand are, from its joints: from a root (the palm, mostly) to its
/// fingers. The joints are those below the root; what carries the root does not matter.
class PointKinematics {
 public:
  virtual ~PointKinematics() = default;

  virtual const std::vector<std::string>& joint_names() const = 0;
  virtual const Eigen::VectorXd& lower() const = 0;  ///< rad; of the ranges of motion
  virtual const Eigen::VectorXd& upper() const = 0;

  /// The site of that name, or the origin of the body. @throws BadInput if there is neither
  virtual HandPoint point(const std::string& name) const = 0;

  /// How far along its link a point lies: 0 at the joint, 1 where the link's shape ends. Between
  /// 0.4 and 0.6 it is in the link's middle. @throws BadInput for a body without any shape
  virtual double share_of_link(const HandPoint& point) const = 0;

  /// Not for two threads at once on one hand. @throws BadInput for another number of joints
  virtual HandPoints evaluate(const Eigen::VectorXd& joints,
                              const std::vector<HandPoint>& points) = 0;
};

}  // namespace palpate::hand
