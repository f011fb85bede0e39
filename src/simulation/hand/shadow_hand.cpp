// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>

#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/hand_joints.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

/// Where the mount's origin lies in the palm's frame: the middle of a grasp, m.
const Eigen::Vector3d kGraspCenter(0.005, -0.045, 0.08);

constexpr double kTipRadius = 0.007;  // m, of BioTac-like capsules
constexpr double kTipBase = 0.0015;   // m from the link's origin to the capsule's end

double tip_length(int finger) { return finger == 0 ? 0.0275 : 0.0265; }

Eigen::Isometry3d pose_in(const mjSpec& spec, const std::string& root, const std::string& name) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const mjsBody* const end = &find_body(spec, root);
  for (mjsBody* body = &find_body(spec, name); body && body != end;
       body = mjs_getParent(body->element)) {
    T = pose3(body->pos, body->quat) * T;
  }
  return T;
}

/// Palm down, fingers along +x, thumb side +y, or, of a left hand, -y.
Eigen::Isometry3d root_at_mount(const mjSpec& spec, const hand::Description& hand, bool left) {
  Eigen::Isometry3d T_mount_palm = Eigen::Isometry3d::Identity();
  T_mount_palm.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // x to +y, y to +z, z to +x
  const Eigen::Vector3d side(left ? -1 : 1, 1, 1);
  T_mount_palm.translation() = -(T_mount_palm.linear() * side.cwiseProduct(kGraspCenter));
  return T_mount_palm * pose_in(spec, hand.file.root, file_link(hand, "palm")).inverse();
}

std::string distal_body(const hand::Description& hand, int finger) {
  std::string name = hand.fingers[static_cast<std::size_t>(finger)].name;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return file_link(hand, name + "distal");
}

hand::TipCapsule tip_of(int finger) {
  return {{0, 0, kTipBase}, {0, 0, tip_length(finger) - kTipRadius}, kTipRadius};
}

void mirror(hand::Preshape& preshape) {
  for (hand::Attitude& attitude : preshape.attitudes) attitude.roll = -attitude.roll;
  preshape.offset.y() = -preshape.offset.y();
}

/// Postures of the left hand: its joints turn the other way, so that angles are the same, and what
/// the mount does is mirrored.
void mirror(hand::Postures& postures) {
  postures.flat.attitude.roll = -postures.flat.attitude.roll;
  postures.flat.center.y() = -postures.flat.center.y();
  for (auto& pointing : postures.pointing) pointing.attitude.roll = -pointing.attitude.roll;
  mirror(postures.top);
  mirror(postures.side);
  for (auto& attitude : postures.far_attitudes) attitude.roll = -attitude.roll;
}

}  // namespace

hand::Description load_shadow_hand(const std::filesystem::path& mjcf, double stiffness_scale) {
  const SpecHandle spec = parse_model(mjcf);
  const bool left = mjs_findBody(spec.get(), "lh_forearm") != nullptr;
  hand::Description hand = hand::shadow_hand();
  if (left) mirror(hand.postures);
  hand.file = {.path = mjcf,
               .root = left ? "lh_forearm" : "rh_forearm",
               .prefix = left ? "lh_" : "rh_",
               .actuator_prefix = left ? "lh_A_" : "rh_A_",
               .own_servos = true};
  hand.file.T_mount_root = root_at_mount(*spec, hand, left);
  place_root(*spec, hand.file);
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    put_tip(*spec, distal_body(hand, finger), tip_geom(hand, finger),
            {distal_body(hand, finger), -1, tip_of(finger)});
  }
  prepare_joints(*spec, hand, stiffness_scale);
  const ModelHandle model = compile(*spec);
  std::vector<int> tips;
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    tips.push_back(find_id(*model, mjOBJ_GEOM, tip_geom(hand, finger)));
  }
  const auto joint_of = [&](const std::string& name) {
    return NamedJoint{hand.joint(name.substr(hand.file.prefix.size())), 1.0};
  };
  read_links(*model, find_id(*model, mjOBJ_BODY, hand.file.root), file_link(hand, "palm"), joint_of,
             tips, hand);
  read_drives(*model, hand);
  return hand;
}

}  // namespace palpate::simulation
