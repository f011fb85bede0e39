// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "palpate/hand/point_kinematics.hpp"

namespace palpate::simulation {

/// Any hand in MJCF; its joints are in the model's order.
class MjcfHand : public hand::PointKinematics {
 public:
  /// @throws BadInput if the file is no MJCF, has no such body, or nothing moves below it
  MjcfHand(const std::filesystem::path& mjcf, const std::string& root);
  ~MjcfHand() override;
  MjcfHand(MjcfHand&&) noexcept;

  const std::vector<std::string>& joint_names() const override { return joint_names_; }
  const Eigen::VectorXd& lower() const override { return lower_; }
  const Eigen::VectorXd& upper() const override { return upper_; }
  hand::HandPoint point(const std::string& name) const override;
  double share_of_link(const hand::HandPoint& point) const override;
  hand::HandPoints evaluate(const Eigen::VectorXd& joints,
                            const std::vector<hand::HandPoint>& points) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<std::string> joint_names_;
  Eigen::VectorXd lower_, upper_;
};

}  // namespace palpate::simulation
