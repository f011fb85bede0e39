// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::tactile {

/// How far contacts and joints are off, as the estimator believes. All standard deviations; how far
/// the links are is the hand's own kinematic_error.
struct ContactErrorModel {
  double point = 0.001;         ///< m, per axis and reading
  double normal = 0.1745;       ///< rad, per tangent axis and reading
  double joint = 0.0087;        ///< rad, per reading
  double point_floor = 0.0005;  ///< m, of what averaging cannot remove
  double normal_floor = 0.12;   ///< rad

  template <class Visitor>
  void visit(Visitor&& v) {
    v("point", point, 0.0, 0.05, "m, error of a contact point, per axis and reading");
    v("normal", normal, 0.0, 1.0, "rad, error of a contact normal, per tangent axis and reading");
    v("joint", joint, 0.0, 0.2, "rad, error of a joint angle, per reading");
    v("point_floor", point_floor, 1e-5, 0.05,
      "m, error of a contact point that averaging does not reduce");
    v("normal_floor", normal_floor, 1e-4, 1.0,
      "rad, error of a contact normal that averaging does not reduce");
  }
};

/// A contact as a reading of its finger holds it.
/// @param contact  in the frame of the finger's distal link
hand::TipContact tip_contact(const Contact& contact);

/// Mean joint angles of some readings, at least one, rad.
hand::JointVector mean_joints(std::span<const hand::HandReading> window);

/// Standard deviation per axis, m, of the place of a fingertip whose links each are off by the
/// hand's kinematic_error: what all contacts of that finger are displaced by alike.
double link_offset_sigma(const hand::Description& hand, int finger);

/// The lasting contacts of a hand that holds still: those of each fingertip clustered by place and
/// direction over the window, averaged, and expressed in the mount's frame with their uncertainty.
///
/// Contacts present in less than a third of the readings are dropped, as are readings whose contact
/// is not finite. Those without a normal (zero) are clustered by place alone, apart from the
/// others.
std::vector<Contact> lasting_contacts(std::span<const hand::HandReading> window,
                                      const hand::Description& hand,
                                      const ContactErrorModel& errors);

/// Those that have a normal; on the others no forces can be distributed.
std::vector<Contact> contacts_with_normals(std::vector<Contact> contacts);

}  // namespace palpate::tactile
