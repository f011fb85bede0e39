// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/load_arm.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/simulation/hand/hand_store.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFlange = "attachment";
constexpr double kPlate = 0.01;  // m, thickness of the adapter

/// Speeds of the makers' data sheets, rad/s, from the stand on.
struct KnownArm {
  std::string_view name;
  std::array<double, 7> speeds;
};
constexpr std::array<KnownArm, 3> kKnownArms = {
    {{"ur10", {2.09, 2.09, 3.14, 3.14, 3.14, 3.14, 0}},
     {"ur5", {3.14, 3.14, 3.14, 3.14, 3.14, 3.14, 0}},
     {"panda", {2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61}}}};

fs::path arm_file(const std::string& name) {
  for (const StoredHand& arm : stored_arms()) {
    if (arm.name != name) continue;
    if (!arm.file.empty()) return arm.file;
    throw BadInput(fmt::format("the arm {0} is not installed: run palpate hand install {0}", name));
  }
  std::error_code error;
  if (fs::is_regular_file(name, error)) return name;
  static const std::vector<std::string> kNames{kFloating, "ur10", "ur5", "panda"};
  throw BadInput(fmt::format("'{}' is neither an arm ({}) nor a file that exists{}", name,
                             fmt::join(kNames, ", "), did_you_mean(name, kNames)));
}

std::string body_name(const mjModel& model, int body) {
  const char* name = mj_id2name(&model, mjOBJ_BODY, body);
  return name ? name : "";
}

/// The actuator that holds a joint at a position.
std::string servo_of(const mjModel& model, int joint, const fs::path& file) {
  for (int i = 0; i < model.nu; ++i) {
    if (model.actuator_trntype[i] != mjTRN_JOINT || model.actuator_trnid[2 * i] != joint) continue;
    const char* name = mj_id2name(&model, mjOBJ_ACTUATOR, i);
    if (name && model.actuator_biastype[i] == mjBIAS_AFFINE) return name;
  }
  throw BadInput(fmt::format("{}: joint {} has no position-controlled actuator with a name",
                             file.string(), mj_id2name(&model, mjOBJ_JOINT, joint)));
}

void read_joints(const mjModel& model, hand::ArmDescription& arm) {
  for (int joint = 0; joint < model.njnt; ++joint) {
    const mjtNum* const range = model.jnt_range + 2 * joint;
    hand::ArmJoint one{.name = mj_id2name(&model, mjOBJ_JOINT, joint), .range = {-7, 7}};
    if (model.jnt_limited[joint]) one.range = {range[0], range[1]};
    arm.joints.push_back(one);
    arm.file.actuators.push_back(servo_of(model, joint, arm.file.path));
  }
  if (arm.joints.empty() || arm.joint_count() > hand::kMaxArmJoints) {
    throw BadInput(fmt::format("{}: an arm has 1 to {} joints, not {}", arm.file.path.string(),
                               hand::kMaxArmJoints, arm.joint_count()));
  }
  for (const KnownArm& known : kKnownArms) {
    if (known.name != arm.name) continue;
    for (std::size_t i = 0; i < arm.joints.size(); ++i) arm.joints[i].max_speed = known.speeds[i];
  }
}

/// The links and their surface, which are read as those of a hand with no fingers.
void read_chain(const mjModel& model, hand::ArmDescription& arm) {
  if (model.nbody < 2) {
    throw BadInput(fmt::format("{}: the model has no body", arm.file.path.string()));
  }
  arm.file.root = body_name(model, 1);
  const int flange = mj_name2id(&model, mjOBJ_BODY, kFlange);
  arm.file.flange = flange < 0 ? body_name(model, static_cast<int>(model.nbody) - 1) : kFlange;
  const auto joint_of = [&](const std::string& name) {
    return NamedJoint{mj_name2id(&model, mjOBJ_JOINT, name.c_str()), 1.0};
  };
  hand::Description chain;
  chain.file.own_servos = true;
  read_links(model, 1, arm.file.flange, joint_of, {}, chain);
  arm.links = std::move(chain.links);
  arm.spheres = std::move(chain.spheres);
  arm.flange = chain.palm;
}

/// The stand faces the workspace's middle.
Eigen::Isometry3d stand(const ArmOptions& options) {
  Eigen::Isometry3d T(Eigen::Translation3d(options.x, options.y, options.z));
  T.rotate(Eigen::AngleAxisd(std::atan2(-options.y, -options.x), Eigen::Vector3d::UnitZ()));
  if (options.hanging) {
    T.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  }
  return T;
}

std::vector<hand::LinkSphere> first_link_spheres(const hand::Description& hand) {
  std::vector<hand::LinkSphere> spheres;
  for (const hand::LinkSphere& ball : hand.spheres) {
    if (ball.link != 0) continue;
    spheres.push_back({0, hand.links.front().T_parent_link * ball.center, ball.radius});
  }
  return spheres;
}

/// The flange in the mount's frame: its axis points at the hand's first body from behind (adapter
/// 0) or above (a quarter turn), an adapter's thickness off all that the body has there.
Eigen::Isometry3d flange_at_mount(const hand::Description& hand, double adapter) {
  const Eigen::Vector3d axis(std::cos(adapter), 0, -std::sin(adapter));
  const Eigen::Vector3d root = hand.file.T_mount_root.translation();
  double back = 0;
  for (const hand::LinkSphere& ball : first_link_spheres(hand)) {
    back = std::max(back, -axis.dot(ball.center - root) + ball.radius);
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear().col(2) = axis;
  T.linear().col(1) = Eigen::Vector3d::UnitY();
  T.linear().col(0) = T.linear().col(1).cross(axis);
  T.translation() = root - (back + kPlate) * axis;
  return T;
}

}  // namespace

std::optional<hand::ArmDescription> load_arm(const ArmOptions& options,
                                             const hand::Description& hand) {
  if (options.name.empty() || options.name == kFloating) return std::nullopt;
  hand::ArmDescription arm;
  arm.name = options.name;
  arm.file.path = arm_file(options.name);
  const SpecHandle spec = parse_model(arm.file.path);
  const ModelHandle model = compile(*spec);
  read_chain(*model, arm);
  read_joints(*model, arm);
  arm.T_world_stand = stand(options);
  arm.T_flange_mount = flange_at_mount(hand, options.adapter).inverse();
  arm.carried = first_link_spheres(hand);
  return arm;
}

}  // namespace palpate::simulation
