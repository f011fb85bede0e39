// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_dynamics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string>

#include "palpate/core/error.hpp"
#include "tasks/relocate/relocate_model.hpp"
#include "tasks/relocate/task_arm.hpp"

namespace palpate::relocate {
namespace {

constexpr int kWrist = 2;
constexpr std::array<const char*, 5> kTips = {"S_thtip", "S_fftip", "S_mftip", "S_rftip",
                                              "S_lftip"};

using Jacobian = Eigen::Matrix<mjtNum, 3, Eigen::Dynamic, Eigen::RowMajor>;

int id_of(const mjModel& model, mjtObj type, const char* name) {
  const int id = mj_name2id(&model, type, name);
  if (id < 0) throw BadInput(fmt::format("the hand's model has no '{}'", name));
  return id;
}

}  // namespace

struct RelocateDynamics::Impl {
  explicit Impl(const RelocateModel& m)
      : owner(m), model(*m.impl().scene.model), data(mj_makeData(&model)) {
    if (!data) throw std::bad_alloc();
    palm = id_of(model, mjOBJ_BODY, "palm");
    forearm = id_of(model, mjOBJ_BODY, "forearm");
    for (std::size_t i = 0; i < kTips.size(); ++i) tips[i] = id_of(model, mjOBJ_SITE, kTips[i]);
  }

  void set(const RelocateJoints& q) {
    RelocateJoints::Map(data->qpos) = q;
    mj_kinematics(&model, data.get());
    mj_comPos(&model, data.get());
  }

  Jacobian jacobian(const Eigen::Vector3d& p, int body) const {
    Jacobian result(3, model.nv);
    mj_jac(&model, data.get(), result.data(), nullptr, p.data(), body);
    return result;
  }

  RelocateModel owner;  // shares the compiled model
  const mjModel& model;
  simulation::DataHandle data;
  int palm = -1, forearm = -1;
  std::array<int, kTips.size()> tips{};
};

RelocateDynamics::RelocateDynamics(const RelocateModel& model)
    : impl_(std::make_unique<Impl>(model)) {
  for (int i = 0; i < kRelocateJoints; ++i) {
    lower_[i] = impl_->model.jnt_range[2 * i];
    upper_[i] = impl_->model.jnt_range[2 * i + 1];
  }
}

RelocateDynamics::~RelocateDynamics() = default;

Eigen::Isometry3d RelocateDynamics::palm(const RelocateJoints& q) {
  impl_->set(q);
  return simulation::pose3(impl_->data->xpos + 3 * impl_->palm,
                           impl_->data->xquat + 4 * impl_->palm);
}

RelocateJoints RelocateDynamics::place_palm(const Eigen::Isometry3d& T_world_palm,
                                            const FingerJoints& fingers) {
  RelocateJoints q = RelocateJoints::Zero();
  const Eigen::Isometry3d T_world_palm_0 = palm(q);
  const mjData& data = *impl_->data;
  const Eigen::Isometry3d T_world_arm_0 =
      simulation::pose3(data.xpos + 3 * impl_->forearm, data.xquat + 4 * impl_->forearm);
  // The base slides along the resting arm's axes, then turns about the arm's origin.
  const Eigen::Isometry3d T =
      T_world_arm_0.inverse() * T_world_palm * T_world_palm_0.inverse() * T_world_arm_0;
  q.head<3>() = T.translation();
  q.segment<3>(3) = xyz_angles(T.linear());
  q.tail<kFingerJoints>() = fingers;
  return q.cwiseMax(lower_).cwiseMin(upper_);
}

RelocateJoints RelocateDynamics::torques(const RelocateJoints& q, const RelocateJoints& velocity,
                                         const RelocateJoints& acceleration, double load) {
  const mjModel& model = impl_->model;
  mjData& data = *impl_->data;
  std::fill_n(data.qvel, model.nv, 0);
  std::fill_n(data.qacc, model.nv, 0);
  impl_->set(q);
  RelocateJoints::Map(data.qvel) = velocity;
  RelocateJoints::Map(data.qacc) = acceleration;
  mj_comVel(&model, &data);
  mj_passive(&model, &data);
  Eigen::VectorXd forces(model.nv);
  mj_rne(&model, &data, 1, forces.data());
  RelocateJoints result = forces.head<kRelocateJoints>();
  for (int i = 0; i < kRelocateJoints; ++i) {
    result[i] += model.dof_armature[i] * acceleration[i] - data.qfrc_passive[i];
  }
  if (load > 0) {
    const Eigen::Vector3d grasp =
        simulation::vector3(data.site_xpos + 3 * impl_->owner.impl().scene.palm);
    const Eigen::Matrix<double, 3, kRelocateJoints> J =
        impl_->jacobian(grasp, impl_->palm).leftCols<kRelocateJoints>();
    result += load * J.transpose() * (J * acceleration - simulation::vector3(model.opt.gravity));
  }
  return result;
}

RelocateJoints RelocateDynamics::press(const RelocateJoints& q, const Eigen::Vector3d& towards,
                                       double force) {
  impl_->set(q);
  RelocateJoints result = RelocateJoints::Zero();
  for (const int tip : impl_->tips) {
    const Eigen::Vector3d p = simulation::vector3(impl_->data->site_xpos + 3 * tip);
    const Eigen::Vector3d way = towards - p;
    if (way.norm() == 0) continue;
    const auto J = impl_->jacobian(p, impl_->model.site_bodyid[tip]);
    result += J.leftCols<kRelocateJoints>().transpose() * (force * way.normalized());
  }
  // The object presses back on the hand as a whole, so base and wrist need not exert anything.
  result.head<kArmJoints + kWrist>().setZero();
  return result;
}

RelocateAction RelocateDynamics::action(const RelocateJoints& q, const RelocateJoints& velocity,
                                        const RelocateJoints& torques) const {
  RelocateAction result;
  for (int i = 0; i < kRelocateJoints; ++i) {
    const mjtNum* const gain = impl_->model.actuator_gainprm + mjNGAIN * i;
    const mjtNum* const bias = impl_->model.actuator_biasprm + mjNBIAS * i;
    result[i] = (torques[i] - bias[0] - bias[1] * q[i] - bias[2] * velocity[i]) / gain[0];
  }
  return (result - impl_->owner.action_center()).cwiseQuotient(impl_->owner.action_half_range());
}

}  // namespace palpate::relocate
