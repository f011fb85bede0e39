// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/sensors/intrinsic_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::tactile {
namespace {

constexpr double kMinCosine = 0.1;  // of the axis with the surface's normal
constexpr int kHalvings = 60;       // of the stretch in which the axis enters
constexpr int kSteps = 200;         // along the axis in which the entry is looked for

void check(const ContactWrench& wrench, const FingertipCapsule& tip,
           const IntrinsicOptions& options) {
  if (!(wrench.f.allFinite() && wrench.m.allFinite() && tip.a.allFinite() && tip.b.allFinite())) {
    throw BadInput("wrench: a force, moment or end of the fingertip is not finite");
  }
  if (!(std::isfinite(tip.radius) && tip.radius > 0)) {
    throw BadInput(fmt::format("wrench: the fingertip's radius is {} m, not positive", tip.radius));
  }
  const Eigen::Vector3d limits(options.min_force, options.force_sigma, options.moment_sigma);
  if (!(limits.allFinite() && limits.minCoeff() > 0)) {
    throw BadInput(
        fmt::format("wrench: min_force, force_sigma and moment_sigma are {}, {} and {}, "
                    "not all positive and finite",
                    options.min_force, options.force_sigma, options.moment_sigma));
  }
}

/// From the nearest point of the segment to p.
Eigen::Vector3d off_axis(const FingertipCapsule& tip, const Eigen::Vector3d& p) {
  const Eigen::Vector3d along = tip.b - tip.a;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0 ? std::clamp((p - tip.a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return p - (tip.a + s * along);
}

double signed_distance(const FingertipCapsule& tip, const Eigen::Vector3d& p) {
  return off_axis(tip, p).norm() - tip.radius;
}

/// First point of the line at the surface, coming from outside along `direction`.
std::optional<Eigen::Vector3d> entry(const FingertipCapsule& tip, const Eigen::Vector3d& through,
                                     const Eigen::Vector3d& direction) {
  const Eigen::Vector3d middle = 0.5 * (tip.a + tip.b);
  const double reach = 0.5 * (tip.b - tip.a).norm() + 2 * tip.radius;
  const double start = (middle - through).dot(direction) - reach;
  const double step = 2 * reach / kSteps;
  for (int i = 1; i <= kSteps; ++i) {
    double inside = start + i * step, outside = inside - step;
    if (signed_distance(tip, through + inside * direction) > 0) continue;
    for (int k = 0; k < kHalvings; ++k) {
      const double between = 0.5 * (inside + outside);
      (signed_distance(tip, through + between * direction) > 0 ? outside : inside) = between;
    }
    return through + inside * direction;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Contact> contact_of_wrench(const ContactWrench& wrench,
                                         const FingertipCapsule& fingertip,
                                         const Eigen::Isometry3d& T_frame_sensor,
                                         const IntrinsicOptions& options) {
  check(wrench, fingertip, options);
  const double force = wrench.f.norm();
  if (!(force > options.min_force)) return std::nullopt;
  const Eigen::Vector3d direction = wrench.f / force;
  const Eigen::Vector3d through = wrench.f.cross(wrench.m) / (force * force);
  const auto p = entry(fingertip, through, direction);
  if (!p) return std::nullopt;
  const Eigen::Vector3d skin = off_axis(fingertip, *p).normalized();
  const double cosine = std::max(kMinCosine, -skin.dot(direction));
  Contact contact;
  contact.p = T_frame_sensor * *p;
  contact.n = -(T_frame_sensor.linear() * skin);
  contact.f = -(T_frame_sensor.linear() * wrench.f);
  contact.point_sigma =
      std::hypot(options.moment_sigma, p->norm() * options.force_sigma) / force / cosine;
  contact.normal_sigma = contact.point_sigma / fingertip.radius;
  return contact;
}

}  // namespace palpate::tactile
