// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "palpate/core/random.hpp"
#include "palpate/grasping/grasp_matrix.hpp"

namespace palpate::grasping {

inline GraspContact contact_at(const Eigen::Vector3d& p, const Eigen::Vector3d& outward,
                               ContactModel model, const Friction& friction = {}) {
  return {contact_frame(p, outward), -1, model, friction};
}

/// Contacts at equal angles around a disc of the given radius in the xy plane.
inline GraspContacts around_disc(int count, double radius, ContactModel model,
                                 const Friction& friction = {}) {
  GraspContacts contacts;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    contacts.push_back(contact_at(radius * out, out, model, friction));
  }
  return contacts;
}

/// Contacts at random places of a ball; the normals are those of the ball.
inline GraspContacts on_ball(int count, double radius, ContactModel model, RandomStream& random) {
  GraspContacts contacts;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d out = random.unit_vector();
    contacts.push_back(contact_at(radius * out, out, model,
                                  {.sliding = random.uniform(0.3, 1.0), .eccentricity = 0.01}));
  }
  return contacts;
}

}  // namespace palpate::grasping
