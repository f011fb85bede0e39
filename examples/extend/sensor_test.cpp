// SPDX-License-Identifier: Apache-2.0
// Add a sensor: a function from its reading to a contact with honest uncertainties, and a test that
// contacts of a known surface give the pose of the object.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/localization/localizer.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::tactile {
namespace {

struct DomeOptions {
  double radius = 0.015;   ///< m
  double min_force = 0.2;  ///< N below which there is no contact
  double friction = 0.3;   ///< the force leaves the normal by at most its angle of friction
};

/// The contact that a rubber dome on a three-axis force sensor senses.
///
/// @param force  of the object on the dome, N, in the sensor's frame, whose origin is the dome's
///               center
/// @param T_frame_sensor  of the sensor in the frame of the contacts
/// @return nothing below min_force; the force's direction stands for the normal, so the angle of
///         friction is the error of the normal and, times the radius, of the point
std::optional<Contact> contact_of_dome(const Eigen::Vector3d& force,
                                       const Eigen::Isometry3d& T_frame_sensor,
                                       const DomeOptions& options = {}) {
  if (force.norm() < options.min_force) return std::nullopt;
  const Eigen::Vector3d inwards = force.normalized();  // of the dome: outwards of the object
  Contact contact;
  contact.p = T_frame_sensor * (-options.radius * inwards);
  contact.n = T_frame_sensor.linear() * inwards;
  contact.f = T_frame_sensor.linear() * -force;
  contact.normal_sigma = std::atan(options.friction) / 2;
  contact.point_sigma = options.radius * contact.normal_sigma;
  return contact;
}

/// What the dome reads where it presses a surface with 2 N and drags along it.
Eigen::Vector3d simulated_force(const Eigen::Vector3d& n, RandomStream& random) {
  const Eigen::Vector3d along = random.normal3().cross(n).normalized();
  return 2 * n + 2 * 0.15 * along + 0.02 * random.normal3();
}

TEST(Dome, LocatesABracket) {
  const geometry::ObjectModel bracket(geometry::load_known_object("bracket"));
  const Eigen::Isometry3d truth =
      Eigen::Translation3d(0.4, 0.1, 0.05) * Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ());
  RandomStream random(7, "dome");
  localization::Evidence evidence;
  for (const auto& sample :
       geometry::sample_surface(bracket.object().mesh, 15, random.fork("points"))) {
    const Eigen::Vector3d n = truth.linear() * sample.normal;
    Eigen::Isometry3d T_world_sensor(Eigen::Translation3d(truth * sample.point + 0.015 * n));
    T_world_sensor.linear() = random.rotation();
    const Eigen::Vector3d force = T_world_sensor.linear().transpose() * simulated_force(n, random);
    evidence.contacts.push_back(contact_of_dome(force, T_world_sensor).value());
  }
  const auto posterior = localization::localize(bracket, evidence, RandomStream(7, "search"));
  ASSERT_FALSE(posterior.modes.empty());
  const auto error = localization::pose_error(posterior.modes.front().T_frame_object, truth,
                                              bracket.object().symmetries);
  EXPECT_LT(error.rotation, 5 * std::numbers::pi / 180);
  EXPECT_LT(error.translation, 0.010);
}

TEST(Dome, SensesNothingBelowItsLeastForce) {
  EXPECT_FALSE(contact_of_dome({0, 0, 0.1}, Eigen::Isometry3d::Identity()));
}

}  // namespace
}  // namespace palpate::tactile
