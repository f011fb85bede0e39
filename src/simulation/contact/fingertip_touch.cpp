// SPDX-License-Identifier: Apache-2.0
#include "simulation/contact/fingertip_touch.hpp"

#include <algorithm>

#include "palpate/core/se3.hpp"

namespace palpate::simulation {

std::optional<FingertipTouch> read_fingertip_touch(const mjModel& model, const mjData& data,
                                                   int contact, const std::vector<int>& tips) {
  const mjContact& found = data.contact[contact];
  for (int side = 0; side < 2; ++side) {
    const auto tip = std::find(tips.begin(), tips.end(), found.geom[side]);
    if (tip == tips.end() || found.geom[1 - side] < 0) continue;
    // The solver's normal and force point from the first body to the second.
    const double sign = side == 0 ? 1 : -1;
    std::array<mjtNum, 6> wrench{};
    mj_contactForce(&model, &data, contact, wrench.data());
    const Eigen::Matrix3d R_world_contact = rotation3(found.frame).transpose();
    const Eigen::Vector3d n = -sign * R_world_contact.col(0);
    const Eigen::Vector3d f = sign * (R_world_contact * vector3(wrench.data()));
    if (!(f.dot(n) < 0)) return std::nullopt;
    const int link = model.geom_bodyid[*tip];
    const Eigen::Matrix3d R_link_world = rotation3(data.xmat + 9 * link).transpose();
    const Eigen::Vector3d p = vector3(found.pos) - 0.5 * found.dist * n;
    FingertipTouch touch{static_cast<int>(tip - tips.begin()), found.geom[1 - side], {}};
    touch.contact.p = R_link_world * (p - vector3(data.xpos + 3 * link));
    touch.contact.n = R_link_world * n;
    touch.contact.f = R_link_world * f;
    return touch;
  }
  return std::nullopt;
}

std::optional<hand::TipContact> with_sensor_noise(hand::TipContact contact,
                                                  const SensorNoise& noise, RandomStream& random) {
  if (-contact.f.dot(contact.n) < noise.touch_threshold) return std::nullopt;
  contact.p += noise.point * random.normal3();
  const Eigen::Matrix3d tangents = frame_with_z(contact.n);
  const double tilt_x = noise.normal * random.normal();
  const double tilt_y = noise.normal * random.normal();
  contact.n = (contact.n + tilt_x * tangents.col(0) + tilt_y * tangents.col(1)).normalized();
  contact.f += noise.force * random.normal3();
  if (!(contact.f.dot(contact.n) < 0)) return std::nullopt;
  return contact;
}

}  // namespace palpate::simulation
