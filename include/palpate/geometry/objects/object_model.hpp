// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/objects/resting_slack.hpp"
#include "palpate/geometry/query/distance_field.hpp"

namespace palpate::geometry {

class Clearance;

/// An object prepared for the search: distance field and surface samples. Shared by threads.
class ObjectModel {
 public:
  explicit ObjectModel(KnownObject object);
  ~ObjectModel();
  ObjectModel(ObjectModel&&) noexcept;
  const KnownObject& object() const { return object_; }
  const DistanceField& field() const { return field_; }
  struct SurfacePoint {
    Eigen::Vector3f p, n;
  };
  const std::vector<SurfacePoint>& surface() const { return surface_; }
  double area() const { return area_; }
  const Clearance& clearance() const { return *clearance_; }
  const Eigen::AlignedBox3f& bounds() const { return bounds_; }
  /// Corners of the convex hull: what can touch a plane.
  const std::vector<Eigen::Vector3f>& hull() const { return hull_; }
  /// One a stable pose.
  const std::vector<RestingSlack>& resting_slack() const { return resting_slack_; }

 private:
  KnownObject object_;
  double area_;
  Eigen::AlignedBox3f bounds_;
  DistanceField field_;
  std::vector<SurfacePoint> surface_;
  std::unique_ptr<const Clearance> clearance_;
  std::vector<Eigen::Vector3f> hull_;
  std::vector<RestingSlack> resting_slack_;
};

}  // namespace palpate::geometry
