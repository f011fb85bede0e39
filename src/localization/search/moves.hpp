// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/likelihood/search_pose.hpp"
#include "palpate/core/random.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Random changes of a pose, each as likely as its reverse.
class Moves {
 public:
  Moves(const geometry::ObjectModel& model, const Evidence& evidence);

  /// @param width  typical step, in units of the contacts' noise
  SearchPose draw(const SearchPose& from, double width, RandomStream& random) const;

 private:
  enum class Kind { about_contacts, about_origin, about_contact_normal, about_own_axis, about_up };
  struct Step {
    double translation, rotation;  // m, rad
  };
  SearchPose jiggled(const SearchPose& from, const Eigen::Vector3f& center, Step step,
                     RandomStream& random) const;
  SearchPose about_contact_normal(const SearchPose& from, Step step, RandomStream& random) const;
  SearchPose about_own_axis(const SearchPose& from, Step step, RandomStream& random) const;
  SearchPose about_up(const SearchPose& from, Step step, RandomStream& random) const;

  struct Anchor {
    Eigen::Vector3f p, n;
  };
  double noise_;  // m
  double lever_;  // m; a rotation of 1 rad moves the surface this far
  std::vector<Anchor> anchors_;
  Eigen::Vector3f center_ = Eigen::Vector3f::Zero();
  Eigen::Matrix3f table_axes_ = Eigen::Matrix3f::Identity();
  std::vector<Kind> kinds_;
};

}  // namespace palpate::localization
