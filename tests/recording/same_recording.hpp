// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "palpate/recording/recording.hpp"

namespace palpate::recording {

template <class Value>
void expect_same(const Value& a, const Value& b) {
  EXPECT_EQ(a, b);
}

inline void expect_same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  EXPECT_EQ(a.matrix(), b.matrix());
}

inline void expect_same_object(const geometry::KnownObject& a, const geometry::KnownObject& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  expect_same(a.T_mesh_object, b.T_mesh_object);
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.mass_properties.volume, b.mass_properties.volume);
  EXPECT_EQ(a.mass_properties.centroid, b.mass_properties.centroid);
  EXPECT_EQ(a.mass_properties.inertia, b.mass_properties.inertia);
  EXPECT_EQ(a.symmetries, b.symmetries);
  EXPECT_EQ(a.repairs, b.repairs);
  ASSERT_EQ(a.stable_poses.size(), b.stable_poses.size());
  for (std::size_t i = 0; i < a.stable_poses.size(); ++i) {
    EXPECT_EQ(a.stable_poses[i].R_table_object, b.stable_poses[i].R_table_object);
    EXPECT_EQ(a.stable_poses[i].height, b.stable_poses[i].height);
    EXPECT_EQ(a.stable_poses[i].probability, b.stable_poses[i].probability);
  }
}

inline void expect_same_range(const hand::Range& a, const hand::Range& b) {
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
}

inline void expect_same_actuator(const hand::Actuator& a, const hand::Actuator& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_EQ(a.joints[i].joint, b.joints[i].joint);
    EXPECT_EQ(a.joints[i].gear, b.joints[i].gear);
    EXPECT_EQ(a.joints[i].share, b.joints[i].share);
    EXPECT_EQ(a.joints[i].offset, b.joints[i].offset);
  }
  EXPECT_EQ(a.coupling.has_value(), b.coupling.has_value());
  EXPECT_EQ(a.finger, b.finger);
  EXPECT_EQ(a.stiffness, b.stiffness);
  expect_same_range(a.command, b.command);
  EXPECT_EQ(a.max_torque, b.max_torque);
  EXPECT_EQ(a.closing, b.closing);
  EXPECT_EQ(a.lever, b.lever);
  expect_same_range(a.bend, b.bend);
}

inline void expect_same_attitudes(const std::vector<hand::Attitude>& a,
                                  const std::vector<hand::Attitude>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].pitch, b[i].pitch);
    EXPECT_EQ(a[i].roll, b[i].roll);
  }
}

inline void expect_same_preshape(const hand::Preshape& a, const hand::Preshape& b) {
  EXPECT_EQ(a.open, b.open);
  EXPECT_EQ(a.closed, b.closed);
  EXPECT_EQ(a.contact_torque, b.contact_torque);
  expect_same_attitudes(a.attitudes, b.attitudes);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.height, b.height);
}

inline void expect_same_postures(const hand::Postures& a, const hand::Postures& b) {
  EXPECT_EQ(a.flat.positions, b.flat.positions);
  expect_same_attitudes({a.flat.attitude}, {b.flat.attitude});
  EXPECT_EQ(a.flat.center, b.flat.center);
  ASSERT_EQ(a.pointing.size(), b.pointing.size());
  for (std::size_t i = 0; i < a.pointing.size(); ++i) {
    EXPECT_EQ(a.pointing[i].finger, b.pointing[i].finger);
    EXPECT_EQ(a.pointing[i].positions, b.pointing[i].positions);
    expect_same_attitudes({a.pointing[i].attitude}, {b.pointing[i].attitude});
  }
  EXPECT_EQ(a.stretched, b.stretched);
  EXPECT_EQ(a.folded, b.folded);
  EXPECT_EQ(a.released, b.released);
  expect_same_preshape(a.top, b.top);
  expect_same_preshape(a.side, b.side);
  expect_same_attitudes(a.far_attitudes, b.far_attitudes);
}

inline void expect_same_drives(const hand::Description& a, const hand::Description& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_EQ(a.joints[i].name, b.joints[i].name);
    expect_same_range(a.joints[i].range, b.joints[i].range);
  }
  ASSERT_EQ(a.actuators.size(), b.actuators.size());
  for (std::size_t i = 0; i < a.actuators.size(); ++i) {
    expect_same_actuator(a.actuators[i], b.actuators[i]);
  }
  EXPECT_EQ(a.thumb, b.thumb);
  expect_same_postures(a.postures, b.postures);
}

inline void expect_same_hand(const hand::Description& a, const hand::Description& b) {
  expect_same_drives(a, b);
  ASSERT_EQ(a.links.size(), b.links.size());
  for (std::size_t i = 0; i < a.links.size(); ++i) {
    EXPECT_EQ(a.links[i].name, b.links[i].name);
    EXPECT_EQ(a.links[i].parent, b.links[i].parent);
    expect_same(a.links[i].T_parent_link, b.links[i].T_parent_link);
    EXPECT_EQ(a.links[i].axis, b.links[i].axis);
    EXPECT_EQ(a.links[i].joint, b.links[i].joint);
  }
  EXPECT_EQ(a.palm, b.palm);
  EXPECT_EQ(a.kinematic_error, b.kinematic_error);
  ASSERT_EQ(a.fingers.size(), b.fingers.size());
  for (std::size_t i = 0; i < a.fingers.size(); ++i) {
    EXPECT_EQ(a.fingers[i].name, b.fingers[i].name);
    EXPECT_EQ(a.fingers[i].link, b.fingers[i].link);
    EXPECT_EQ(a.fingers[i].tip.a, b.fingers[i].tip.a);
    EXPECT_EQ(a.fingers[i].tip.b, b.fingers[i].tip.b);
    EXPECT_EQ(a.fingers[i].tip.radius, b.fingers[i].tip.radius);
    ASSERT_EQ(a.fingers[i].hull.has_value(), b.fingers[i].hull.has_value());
    if (!a.fingers[i].hull) continue;
    EXPECT_EQ(a.fingers[i].hull->core, b.fingers[i].hull->core);
    EXPECT_EQ(a.fingers[i].hull->radius, b.fingers[i].hull->radius);
  }
  ASSERT_EQ(a.spheres.size(), b.spheres.size());
  for (std::size_t i = 0; i < a.spheres.size(); ++i) {
    EXPECT_EQ(a.spheres[i].link, b.spheres[i].link);
    EXPECT_EQ(a.spheres[i].center, b.spheres[i].center);
    EXPECT_EQ(a.spheres[i].radius, b.spheres[i].radius);
  }
}

inline void expect_same_reading(const hand::HandReading& a, const hand::HandReading& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.joints, b.joints);
  EXPECT_EQ(a.torques, b.torques);
  EXPECT_EQ(a.mount.xyz, b.mount.xyz);
  EXPECT_EQ(a.mount.ypr, b.mount.ypr);
  EXPECT_EQ(a.mount_force, b.mount_force);
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t finger = 0; finger < a.contacts.size(); ++finger) {
    ASSERT_EQ(a.contacts[finger].size(), b.contacts[finger].size());
    for (std::size_t i = 0; i < a.contacts[finger].size(); ++i) {
      EXPECT_EQ(a.contacts[finger][i].p, b.contacts[finger][i].p);
      EXPECT_EQ(a.contacts[finger][i].n, b.contacts[finger][i].n);
      EXPECT_EQ(a.contacts[finger][i].f, b.contacts[finger][i].f);
    }
  }
}

inline void expect_same_frame(const Frame& a, const Frame& b) {
  expect_same_reading(a.reading, b.reading);
  EXPECT_EQ(a.command.positions, b.command.positions);
  EXPECT_EQ(a.command.mount.xyz, b.command.mount.xyz);
  EXPECT_EQ(a.command.mount.ypr, b.command.mount.ypr);
  ASSERT_EQ(a.truth.has_value(), b.truth.has_value());
  if (!a.truth) return;
  expect_same(a.truth->T_world_object, b.truth->T_world_object);
  EXPECT_EQ(a.truth->joints, b.truth->joints);
}

inline void expect_same_estimate(const EstimateRecord& a, const EstimateRecord& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.status, b.status);
  ASSERT_EQ(a.modes.size(), b.modes.size());
  for (std::size_t i = 0; i < a.modes.size(); ++i) {
    expect_same(a.modes[i].T_world_object, b.modes[i].T_world_object);
    EXPECT_EQ(a.modes[i].weight, b.modes[i].weight);
    EXPECT_EQ(a.modes[i].covariance, b.modes[i].covariance);
    ASSERT_EQ(a.modes[i].free_axis.has_value(), b.modes[i].free_axis.has_value());
    if (!a.modes[i].free_axis) continue;
    EXPECT_EQ(a.modes[i].free_axis->point, b.modes[i].free_axis->point);
    EXPECT_EQ(a.modes[i].free_axis->direction, b.modes[i].free_axis->direction);
    EXPECT_EQ(a.modes[i].free_axis->extent, b.modes[i].free_axis->extent);
  }
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    EXPECT_EQ(a.contacts[i].finger, b.contacts[i].finger);
    EXPECT_EQ(a.contacts[i].time, b.contacts[i].time);
    EXPECT_EQ(a.contacts[i].p, b.contacts[i].p);
    EXPECT_EQ(a.contacts[i].n, b.contacts[i].n);
    EXPECT_EQ(a.contacts[i].f, b.contacts[i].f);
    EXPECT_EQ(a.contacts[i].point_sigma, b.contacts[i].point_sigma);
    EXPECT_EQ(a.contacts[i].normal_sigma, b.contacts[i].normal_sigma);
  }
}

inline void expect_same_events(const std::vector<Event>& a, const std::vector<Event>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].time, b[i].time);
    EXPECT_EQ(a[i].kind, b[i].kind);
    EXPECT_EQ(a[i].phase, b[i].phase);
    EXPECT_EQ(a[i].text, b[i].text);
  }
}

inline void expect_same_recording(const Recording& a, const Recording& b) {
  EXPECT_EQ(a.header.program_version, b.header.program_version);
  EXPECT_EQ(a.header.seed, b.header.seed);
  EXPECT_EQ(a.header.config_toml, b.header.config_toml);
  expect_same_object(a.header.object, b.header.object);
  expect_same_hand(a.header.hand, b.header.hand);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) expect_same_frame(a.frames[i], b.frames[i]);
  expect_same_events(a.events, b.events);
  ASSERT_EQ(a.estimates.size(), b.estimates.size());
  for (std::size_t i = 0; i < a.estimates.size(); ++i) {
    expect_same_estimate(a.estimates[i], b.estimates[i]);
  }
}

}  // namespace palpate::recording
