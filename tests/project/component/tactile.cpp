// SPDX-License-Identifier: Apache-2.0
#include <palpate/tactile/normals/normal_estimator.hpp>
#include <palpate/tactile/sensors/intrinsic_contact.hpp>

int main() {
  using namespace palpate::tactile;
  FingertipCapsule fingertip;
  fingertip.radius = 0.01;
  const ContactWrench pressed_at_the_tip{.f = {0, 0, -1}, .m = {0, 0, 0}};
  const auto contact =
      contact_of_wrench(pressed_at_the_tip, fingertip, Eigen::Isometry3d::Identity());
  return contact && !normal_estimators().empty() ? 0 : 1;
}
