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
constexpr double kPlate = 0.01;           // m, thickness of the adapter
constexpr double kRoundedCommand = 1e-3;  // rad: files round the same limit in two ways
constexpr double kRoundedGain = 1e-6;     // relative

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

/// What the mount is fixed to.
struct Flange {
  int body = 0;
  std::optional<Eigen::Isometry3d> T_body_flange = {};  ///< none: the body's own frame
};

Flange find_flange(const mjModel& model, const fs::path& file) {
  const int body = mj_name2id(&model, mjOBJ_BODY, kFlange);
  if (body > 0) return {.body = body};
  for (const char* name : {"attachment_site", kFlange}) {
    const int site = mj_name2id(&model, mjOBJ_SITE, name);
    if (site < 0 || model.site_bodyid[site] == 0) continue;
    return {model.site_bodyid[site], pose3(model.site_pos + 3 * site, model.site_quat + 4 * site)};
  }
  std::vector<std::string> bodies;
  for (int i = 1; i < model.nbody; ++i) bodies.push_back(body_name(model, i));
  throw BadInput(fmt::format("{}: no body or site called {} at the flange; the bodies are: {}",
                             file.string(), kFlange, fmt::join(bodies, ", ")));
}

std::string arm_joint_name(const mjModel& model, int joint) {
  return mj_id2name(&model, mjOBJ_JOINT, joint);
}

/// The joints that move the flange, from the stand on.
/// @throws BadInput if the arm has others
std::vector<int> chain_of(const mjModel& model, int flange, const fs::path& file) {
  std::vector<int> chain;
  for (int body = flange; body > 0; body = model.body_parentid[body]) {
    for (int i = model.body_jntnum[body]; i-- > 0;) chain.push_back(model.body_jntadr[body] + i);
  }
  std::ranges::reverse(chain);
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (model.body_rootid[model.jnt_bodyid[joint]] != model.body_rootid[flange]) continue;
    if (std::ranges::find(chain, joint) != chain.end()) continue;
    throw BadInput(fmt::format("{}: joint {} does not move the flange, {}: remove what it moves",
                               file.string(), arm_joint_name(model, joint),
                               body_name(model, flange)));
  }
  return chain;
}

/// Whether the actuator's command is the joint's angle.
bool commands_angle(const mjModel& model, int actuator) {
  const mjtNum* const gain = model.actuator_gainprm + mjNGAIN * actuator;
  const mjtNum* const bias = model.actuator_biasprm + mjNBIAS * actuator;
  return model.actuator_gaintype[actuator] == mjGAIN_FIXED &&
         model.actuator_biastype[actuator] == mjBIAS_AFFINE &&
         model.actuator_dyntype[actuator] != mjDYN_INTEGRATOR &&
         model.actuator_gear[6 * actuator] == 1 && gain[0] > 0 && bias[0] == 0 &&
         std::abs(gain[0] + bias[1]) <= kRoundedGain * gain[0];
}

/// The actuator that holds a joint at a position.
int servo_of(const mjModel& model, int joint, const fs::path& file) {
  std::string others;
  for (int i = 0; i < model.nu; ++i) {
    if (model.actuator_trntype[i] != mjTRN_JOINT || model.actuator_trnid[2 * i] != joint) continue;
    const char* name = mj_id2name(&model, mjOBJ_ACTUATOR, i);
    if (!name) continue;
    if (commands_angle(model, i)) return i;
    others = fmt::format(" ({} is no position servo with gear 1)", name);
  }
  throw BadInput(fmt::format("{}: joint {} has no position-controlled actuator with a name{}",
                             file.string(), arm_joint_name(model, joint), others));
}

/// @throws BadInput if an equality ties the joint to something
void refuse_equality(const mjModel& model, int joint, const fs::path& file) {
  for (int i = 0; i < model.neq; ++i) {
    if (model.eq_type[i] != mjEQ_JOINT || !model.eq_active0[i]) continue;
    if (model.eq_obj1id[i] != joint && model.eq_obj2id[i] != joint) continue;
    throw BadInput(fmt::format("{}: joint {} is tied by an equality; the joints of an arm are free",
                               file.string(), arm_joint_name(model, joint)));
  }
}

/// Angles that the joint may have and the servo may be commanded.
hand::Range range_of_joint(const mjModel& model, int joint, int servo, const fs::path& file) {
  hand::Range range{-7, 7};
  if (model.jnt_limited[joint]) {
    range = {model.jnt_range[2 * joint], model.jnt_range[2 * joint + 1]};
  }
  if (!model.actuator_ctrllimited[servo]) return range;
  const mjtNum* const command = model.actuator_ctrlrange + 2 * servo;
  if (command[0] > range.low + kRoundedCommand) range.low = command[0];
  if (command[1] < range.high - kRoundedCommand) range.high = command[1];
  if (range.low < range.high) return range;
  throw BadInput(
      fmt::format("{}: the range of joint {} and the ctrlrange of its actuator, {} to "
                  "{}, have nothing in common",
                  file.string(), arm_joint_name(model, joint), command[0], command[1]));
}

void read_joints(const mjModel& model, const std::vector<int>& chain, hand::ArmDescription& arm) {
  const fs::path& file = arm.file.path;
  for (const int joint : chain) {
    refuse_equality(model, joint, file);
    const int servo = servo_of(model, joint, file);
    arm.joints.push_back(
        {.name = arm_joint_name(model, joint), .range = range_of_joint(model, joint, servo, file)});
    arm.file.actuators.emplace_back(mj_id2name(&model, mjOBJ_ACTUATOR, servo));
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

/// The links and their surface, which are read as those of a hand with no fingers. Other bodies of
/// the world are not the arm's.
void read_chain(const mjModel& model, int flange, const std::vector<int>& chain,
                hand::ArmDescription& arm) {
  const int root = model.body_rootid[flange];
  arm.file.root = body_name(model, root);
  arm.file.flange = body_name(model, flange);
  const auto joint_of = [&](const std::string& name) {
    const int id = mj_name2id(&model, mjOBJ_JOINT, name.c_str());
    const auto place = std::ranges::find(chain, id) - chain.begin();
    return NamedJoint{static_cast<int>(place), 1.0};
  };
  hand::Description links;
  links.file.own_servos = true;
  read_links(model, root, arm.file.flange, joint_of, {}, links, RootJoints::kept);
  links.links.front().T_parent_link.translation() -= vector3(model.body_pos + 3 * root);
  arm.links = std::move(links.links);
  arm.spheres = std::move(links.spheres);
  arm.flange = links.palm;
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
  const SpecHandle spec = parse_model(arm.file.path, nullptr, "arm");
  const ModelHandle model = compile(*spec);
  const Flange flange = find_flange(*model, arm.file.path);
  const std::vector<int> chain = chain_of(*model, flange.body, arm.file.path);
  read_chain(*model, flange.body, chain, arm);
  read_joints(*model, chain, arm);
  arm.T_world_stand = stand(options);
  arm.T_flange_mount = flange_at_mount(hand, options.adapter).inverse();
  if (flange.T_body_flange) arm.T_flange_mount = *flange.T_body_flange * arm.T_flange_mount;
  arm.carried = first_link_spheres(hand);
  return arm;
}

}  // namespace palpate::simulation
