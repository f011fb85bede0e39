// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/simulated_biotacs.hpp"

#include <algorithm>
#include <limits>

#include "palpate/tactile/biotac/fingers.hpp"

namespace palpate::simulation {
namespace {

hand::TipContact in_sensor(const hand::TipContact& contact,
                           const Eigen::Isometry3d& T_sensor_link) {
  return {.p = T_sensor_link * contact.p,
          .n = T_sensor_link.linear() * contact.n,
          .f = T_sensor_link.linear() * contact.f};
}

}  // namespace

SimulatedBiotacs::SimulatedBiotacs(const geometry::MeshQuery& object, const hand::Description& hand,
                                   const RandomStream& random)
    : object_(object), skin_(std::make_unique<const tactile::BiotacSkin>()) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const auto i = static_cast<std::uint64_t>(finger);
    mounts_.push_back(tactile::biotac_mount(hand, finger));
    sensors_.emplace_back(*skin_, tactile::BiotacSensorOptions{}, random.fork("sensor", i));
  }
}

void SimulatedBiotacs::reset() {
  for (auto& sensor : sensors_) sensor.reset();
}

tactile::SkinState SimulatedBiotacs::press(const TipLoad& load,
                                           const Eigen::Isometry3d& mount) const {
  const Eigen::Isometry3d T_sensor_link = mount.inverse();
  const Eigen::Isometry3d T_object_sensor = load.T_object_link * mount;
  std::vector<hand::TipContact> contacts, planes;
  for (const auto& contact : load.on_object) contacts.push_back(in_sensor(contact, T_sensor_link));
  for (const auto& contact : load.on_others) planes.push_back(in_sensor(contact, T_sensor_link));
  contacts.insert(contacts.end(), planes.begin(), planes.end());
  if (contacts.empty()) return {};
  const auto surface = [&](const Eigen::Vector3d& x) {
    double distance = std::numeric_limits<double>::infinity();
    if (!load.on_object.empty()) {
      const Eigen::Vector3d p = T_object_sensor * x;
      const auto closest = object_.closest_point(p);
      const bool inside = closest.normal.dot(p - closest.point) < 0;
      distance = inside ? -closest.distance : closest.distance;
    }
    for (const auto& plane : planes) distance = std::min(distance, plane.n.dot(x - plane.p));
    return distance;
  };
  return skin_->press(contacts, surface);
}

std::vector<hand::BiotacReading> SimulatedBiotacs::step(const std::vector<TipLoad>& loads,
                                                        double time) {
  std::vector<hand::BiotacReading> readings;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    readings.push_back(sensors_[i].step(press(loads[i], mounts_[i])));
    readings.back().time = time;
  }
  return readings;
}

}  // namespace palpate::simulation
