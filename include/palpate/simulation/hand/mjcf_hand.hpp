// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace palpate::simulation {

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

/// Kinematics of any hand in MJCF, from a root body (the palm, mostly) to its fingers. The joints
/// are those below the root, in the model's order; what carries the root does not matter.
class MjcfHand {
 public:
  /// @throws BadInput if the file is no MJCF, has no such body, or nothing moves below it
  MjcfHand(const std::filesystem::path& mjcf, const std::string& root);
  ~MjcfHand();
  MjcfHand(MjcfHand&&) noexcept;

  const std::vector<std::string>& joint_names() const { return joint_names_; }
  const Eigen::VectorXd& lower() const { return lower_; }  ///< rad; of the ranges of motion
  const Eigen::VectorXd& upper() const { return upper_; }

  /// The site of that name, or the origin of the body. @throws BadInput if there is neither
  HandPoint point(const std::string& name) const;

  /// How far along its link a point lies: 0 at the joint, 1 where the link's shape ends. Between
  /// 0.4 and 0.6 it is in the link's middle. @throws BadInput for a body without any shape
  double share_of_link(const HandPoint& point) const;

  /// Not for two threads at once on one hand. @throws BadInput for another number of joints
  HandPoints evaluate(const Eigen::VectorXd& joints, const std::vector<HandPoint>& points);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<std::string> joint_names_;
  Eigen::VectorXd lower_, upper_;
};

}  // namespace palpate::simulation
