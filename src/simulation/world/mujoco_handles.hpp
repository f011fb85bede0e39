// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <memory>
#include <new>

namespace palpate::simulation {

struct MuJoCoDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

using SpecHandle = std::unique_ptr<mjSpec, MuJoCoDeleter>;
using ModelHandle = std::unique_ptr<mjModel, MuJoCoDeleter>;
using DataHandle = std::unique_ptr<mjData, MuJoCoDeleter>;

/// @throws std::bad_alloc
inline DataHandle make_data(const mjModel& model) {
  DataHandle data(mj_makeData(&model));
  if (!data) throw std::bad_alloc();
  return data;
}

inline Eigen::Vector3d vector3(const mjtNum* values) { return Eigen::Vector3d(values); }

/// Rotation of nine row-major numbers.
inline Eigen::Matrix3d rotation3(const mjtNum* values) {
  return Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(values);
}

/// Pose of a position and a quaternion (w, x, y, z) of any positive length.
inline Eigen::Isometry3d pose3(const mjtNum* position, const mjtNum* quat_wxyz) {
  const Eigen::Quaterniond q(quat_wxyz[0], quat_wxyz[1], quat_wxyz[2], quat_wxyz[3]);
  return Eigen::Translation3d(vector3(position)) * q.normalized();
}

/// Pose of a body in the world.
inline Eigen::Isometry3d body_pose(const mjData& data, int body) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation3(data.xmat + 9 * body);
  T.translation() = vector3(data.xpos + 3 * body);
  return T;
}

/// Writes a pose as position and quaternion (w, x, y, z).
inline void write_pose(const Eigen::Isometry3d& T, mjtNum* position, mjtNum* quat_wxyz) {
  const Eigen::Quaterniond q(T.linear());
  Eigen::Vector3d::Map(position) = T.translation();
  Eigen::Vector4d::Map(quat_wxyz) << q.w(), q.x(), q.y(), q.z();
}

}  // namespace palpate::simulation
