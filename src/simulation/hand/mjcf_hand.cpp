// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/mjcf_hand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <new>

#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/warnings.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {
namespace {

using hand::HandPoint;
using hand::HandPoints;

constexpr double kEndless = 1e3;  // rad, for a joint without limits

ModelHandle load(const std::filesystem::path& mjcf) {
  std::array<char, 1000> error{};
  const SpecHandle spec(mj_parseXML(mjcf.c_str(), nullptr, error.data(), error.size()));
  if (!spec) throw BadInput(fmt::format("{}: {}", mjcf.string(), one_line(error.data())));
  mjs_discardVisual(spec.get(), nullptr);
  return compile(*spec);
}

bool is_below(const mjModel& model, int body, int root) {
  while (body > 0 && body != root) body = model.body_parentid[body];
  return body == root;
}

/// The farthest that a geom reaches from its body's origin in a direction (unit, body's axes), m.
double reach(const mjModel& model, int geom, const Eigen::Vector3d& direction) {
  const Eigen::Isometry3d T = pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  const mjtNum* const box = model.geom_aabb + 6 * geom;  // center and half sizes
  const Eigen::Vector3d along = T.linear().transpose() * direction;
  return direction.dot(T * vector3(box)) + along.cwiseAbs().dot(vector3(box + 3));
}

Eigen::Vector3d middle(const mjModel& model, int geom) {
  return pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom) *
         vector3(model.geom_aabb + 6 * geom);
}

}  // namespace

struct MjcfHand::Impl {
  ModelHandle model;
  DataHandle data;
  int root = -1;
  std::vector<int> joints;  // of the model
};

MjcfHand::MjcfHand(const std::filesystem::path& mjcf, const std::string& root)
    : impl_(std::make_unique<Impl>()) {
  impl_->model = load(mjcf);
  const mjModel& model = *impl_->model;
  impl_->data.reset(mj_makeData(&model));
  if (!impl_->data) throw std::bad_alloc();
  impl_->root = mj_name2id(&model, mjOBJ_BODY, root.c_str());
  if (impl_->root < 0) throw BadInput(fmt::format("{} has no body '{}'", mjcf.string(), root));
  for (int joint = 0; joint < model.njnt; ++joint) {
    const int body = model.jnt_bodyid[joint];
    if (body == impl_->root || !is_below(model, body, impl_->root)) continue;
    if (model.jnt_type[joint] != mjJNT_HINGE) {
      throw BadInput(fmt::format("{}: a joint below {} is no hinge", mjcf.string(), root));
    }
    impl_->joints.push_back(joint);
  }
  if (impl_->joints.empty()) {
    throw BadInput(fmt::format("{}: nothing moves below '{}'", mjcf.string(), root));
  }
  lower_.resize(std::ssize(impl_->joints));
  upper_.resize(lower_.size());
  for (Eigen::Index i = 0; i < lower_.size(); ++i) {
    const int joint = impl_->joints[static_cast<std::size_t>(i)];
    const char* const name = mj_id2name(&model, mjOBJ_JOINT, joint);
    joint_names_.emplace_back(name ? name : "");
    lower_[i] = model.jnt_limited[joint] ? model.jnt_range[2 * joint] : -kEndless;
    upper_[i] = model.jnt_limited[joint] ? model.jnt_range[2 * joint + 1] : kEndless;
  }
}

MjcfHand::~MjcfHand() = default;
MjcfHand::MjcfHand(MjcfHand&&) noexcept = default;

HandPoint MjcfHand::point(const std::string& name) const {
  const mjModel& model = *impl_->model;
  const int site = mj_name2id(&model, mjOBJ_SITE, name.c_str());
  if (site >= 0) return {name, model.site_bodyid[site], vector3(model.site_pos + 3 * site)};
  const int body = mj_name2id(&model, mjOBJ_BODY, name.c_str());
  if (body < 0) throw BadInput(fmt::format("the hand has no site and no body '{}'", name));
  return {name, body, Eigen::Vector3d::Zero()};
}

double MjcfHand::share_of_link(const HandPoint& point) const {
  const mjModel& model = *impl_->model;
  const int first = model.body_geomadr[point.body], count = model.body_geomnum[point.body];
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (int i = 0; i < count; ++i) center += middle(model, first + i) / count;
  if (count == 0 || center.norm() == 0) {
    throw BadInput(fmt::format("the link of '{}' has no shape: its end is unknown", point.name));
  }
  const Eigen::Vector3d along = center.normalized();
  double end = 0;
  for (int i = 0; i < count; ++i) end = std::max(end, reach(model, first + i, along));
  return along.dot(point.p_body) / end;
}

HandPoints MjcfHand::evaluate(const Eigen::VectorXd& joints, const std::vector<HandPoint>& points) {
  if (joints.size() != lower_.size()) {
    throw BadInput(fmt::format("{} joint angles of {}", joints.size(), lower_.size()));
  }
  const mjModel& model = *impl_->model;
  mjData& data = *impl_->data;
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    data.qpos[model.jnt_qposadr[impl_->joints[static_cast<std::size_t>(i)]]] = joints[i];
  }
  mj_kinematics(&model, &data);
  mj_comPos(&model, &data);  // what the Jacobian is made of
  const Eigen::Matrix3d R_root_world = rotation3(data.xmat + 9 * impl_->root).transpose();
  const Eigen::Vector3d root = vector3(data.xpos + 3 * impl_->root);
  const auto count = static_cast<Eigen::Index>(points.size());
  HandPoints result{Eigen::Matrix3Xd(3, count), Eigen::MatrixXd(3 * count, joints.size())};
  Eigen::Matrix<mjtNum, 3, Eigen::Dynamic, Eigen::RowMajor> of_all(3, model.nv);
  for (Eigen::Index k = 0; k < count; ++k) {
    const HandPoint& point = points[static_cast<std::size_t>(k)];
    const Eigen::Vector3d world =
        vector3(data.xpos + 3 * point.body) + rotation3(data.xmat + 9 * point.body) * point.p_body;
    result.positions.col(k) = R_root_world * (world - root);
    mj_jac(&model, &data, of_all.data(), nullptr, world.data(), point.body);
    for (Eigen::Index i = 0; i < joints.size(); ++i) {
      const int address = model.jnt_dofadr[impl_->joints[static_cast<std::size_t>(i)]];
      result.jacobian.block<3, 1>(3 * k, i) = R_root_world * of_all.col(address);
    }
  }
  return result;
}

}  // namespace palpate::simulation
