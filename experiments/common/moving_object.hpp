// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/localization/localizer.hpp"
#include "palpate/localization/tracking/tracker.hpp"

namespace palpate::experiment {

/// How fingertips sense an object that moves with them, 100 frames a second: 2 cm/s and 20 deg/s
/// rms.
struct TouchSetting {
  std::string name;
  double sliding;   ///< rms m/s of a fingertip on the surface
  bool correlated;  ///< half of the noise's variance keeps for 0.5 s, else all is white
  bool slip;        ///< half way
};

inline constexpr double kFrame = 0.01;             // s
inline constexpr double kNoiseTime = 0.5;          // s, correlation of what keeps
inline constexpr double kCorrelatedShare = 0.5;    // of the noise's variance
inline constexpr double kPointNoise = 0.001;       // m per axis
inline constexpr double kNormalNoise = 0.1745;     // rad per axis
inline constexpr double kSlipWay = 0.005;          // m
inline constexpr double kSlipAngle = 0.174532925;  // rad

/// An object with its mesh as it is asked.
struct Subject {
  explicit Subject(const std::string& name)
      : model(geometry::load_known_object(name)), mesh(model.object().mesh) {}
  geometry::ObjectModel model;
  geometry::MeshQuery mesh;
};

/// A random vector that keeps for a while (Ornstein-Uhlenbeck), of unit variance per axis.
class Wandering {
 public:
  Wandering(double time, RandomStream& random);
  const Eigen::Vector3d& next(RandomStream& random);
  [[nodiscard]] const Eigen::Vector3d& value() const { return value_; }

 private:
  double keep_;
  Eigen::Vector3d value_;
};

/// A fingertip on the moving object.
struct TouchingTip {
  Eigen::Vector3d p, n;  ///< in the object's frame
  Wandering slide, point_error, normal_error;
};

/// An object on which five fingertips ride, and what they sense.
class MovingObject {
 public:
  MovingObject(const Subject& subject, const TouchSetting& setting, RandomStream random);

  localization::TrackFrame next(double time);

  /// The object jumps by kSlipWay and kSlipAngle; the fingertips stay where they are.
  void slip();

  [[nodiscard]] const Eigen::Isometry3d& truth() const { return T_; }
  [[nodiscard]] const std::vector<TouchingTip>& tips() const { return tips_; }

 private:
  void place_fingertips();
  void settle(TouchingTip& tip, const Eigen::Vector3d& near) const;
  tactile::Contact sensed_contact(TouchingTip& tip);

  const Subject& subject_;
  TouchSetting setting_;
  RandomStream random_;
  Wandering turning_, moving_;
  Eigen::Isometry3d T_ = Eigen::Isometry3d::Identity();
  std::vector<TouchingTip> tips_;
};

}  // namespace palpate::experiment
