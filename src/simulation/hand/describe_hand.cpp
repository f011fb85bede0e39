// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/describe_hand.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "simulation/hand/anatomy.hpp"
#include "simulation/hand/closing_joints.hpp"
#include "simulation/hand/hand_joints.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/mimic_joints.hpp"
#include "simulation/hand/model_checks.hpp"
#include "simulation/hand/overlapping_links.hpp"
#include "simulation/hand/tip_capsule.hpp"

namespace palpate::simulation {
namespace {

constexpr double kTipStiffness = 300;                      // N/m, of a servo at the fingertip
constexpr double kMinStiffness = 0.5, kMaxStiffness = 12;  // N m/rad
constexpr double kNaturalFrequency = 40;                   // rad/s, of a joint on its servo
constexpr double kUsualTorque = 1.0;                       // N m, where the file names no limit
constexpr double kOneSided = 0.3;  // asymmetry of a range from which a joint flexes a finger
constexpr double kLeastBend = 0.1, kUsualBend = 1.57;  // rad: suspiciously few; without limits
constexpr double kHalf = 0.35;  // share of the way to closed at which the hand is measured

/// Largest torque of the servos that drive a joint, N m; 0 where the file does not say.
double torque_limit(const mjModel& model, int joint) {
  if (model.jnt_actfrclimited[joint]) return model.jnt_actfrcrange[2 * joint + 1];
  for (int i = 0; i < model.nu; ++i) {
    if (model.actuator_trntype[i] != mjTRN_JOINT || model.actuator_trnid[2 * i] != joint) continue;
    if (model.actuator_forcelimited[i]) return model.actuator_forcerange[2 * i + 1];
  }
  return 0;
}

Eigen::Isometry3d given_mount(const HandNotes& notes) {
  const Eigen::Vector3d rpy = notes.mount_rpy * std::numbers::pi / 180;
  return Eigen::Translation3d(notes.mount_xyz) *
         Eigen::Quaterniond(Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
}

class Describer {
 public:
  Describer(const std::filesystem::path& file, const HandNotes& notes)
      : file_(file), notes_(notes) {
    std::vector<std::string> warnings;
    spec_ = parse_model(file, &warnings);
    for (const std::string& warning : warnings) {
      problem("the simulator warns: " + warning, "see the file");
    }
    result_.hand.name = file.string();
    result_.hand.file.path = std::filesystem::absolute(file);
  }

  DescribedHand run() {
    result_.hand.file.root = find_root(*spec_, notes_);
    find_body(*spec_, result_.hand.file.root);
    free_from_joints(*spec_, result_.hand.file.root);
    const ModelHandle model = compile(*spec_);
    check_masses(*model);
    check_shapes(*model);
    refuse_closed_loops(*model);
    for (const std::string& tendon : tendons(*model)) {
      problem(fmt::format("tendon {} is left out", tendon),
              "its joints get a drive each; tie joints by an equality instead");
    }
    const Anatomy anatomy(*model, result_.hand.file.root, notes_);
    read_joints(*model, anatomy);
    read_fingers(*model, anatomy);
    read_couplings(*model);
    add_drives(*model);
    measure(anatomy, *model);
    check_size(hand());
    find_thumb();
    if (!ranges_determine_closing(hand())) set_closing();
    place_mount();
    set_closing();
    set_gains(*model);
    exclude_overlaps();
    return std::move(result_);
  }

 private:
  hand::Description& hand() { return result_.hand; }
  void guess(std::string text) { result_.guesses.push_back(std::move(text)); }
  void problem(std::string what, std::string hint) {
    result_.problems.push_back({std::move(what), std::move(hint)});
  }

  void set_closing() {
    if (notes_.closing.empty()) {
      derive_closing(hand());
    } else {
      simulation::set_closing(listed(notes_.closing), hand());
    }
  }

  void read_joints(const mjModel& model, const Anatomy& anatomy);
  void read_fingers(const mjModel& model, const Anatomy& anatomy);
  void read_couplings(const mjModel& model);
  void add_drives(const mjModel& model);
  void measure(const Anatomy& anatomy, const mjModel& model);
  void find_thumb();
  int named_thumb() const;
  void place_mount();
  Eigen::Isometry3d derived_mount();
  void set_gains(const mjModel& model);
  void exclude_overlaps();
  bool on_chain(int joint, const Chain& chain, const mjModel& model) const;
  hand::ActuatorVector posture(double share) const;
  std::vector<Eigen::Vector3d> tips_at(double share) const;

  std::filesystem::path file_;
  HandNotes notes_;
  SpecHandle spec_;
  DescribedHand result_;
  std::vector<Chain> chains_;
  std::vector<int> joint_ids_;      // in the model, of the hand's joints
  std::vector<MimicJoint> mimics_;  // by name
};

void Describer::read_joints(const mjModel& model, const Anatomy& anatomy) {
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (!anatomy.is_below(model.jnt_bodyid[joint])) continue;
    const std::string name = model_name(model, mjOBJ_JOINT, joint);
    hand::Range range{model.jnt_range[2 * joint], model.jnt_range[2 * joint + 1]};
    check_limits(name, range);
    if (!model.jnt_limited[joint] || !(range.high > range.low)) {
      const char* const limits = range.high < range.low ? "reversed limits" : "no limits";
      problem(fmt::format("{} of joint {}", limits, name),
              fmt::format("give it a range in the file; 0 .. {} rad is used", kUsualBend));
      range = {0, kUsualBend};
    }
    if (const double turn = range.high - range.low; turn < kLeastBend) {
      problem(fmt::format("joint {} turns by {:.3f} rad only", name, turn),
              "are its limits in radians where the file's angles are degrees?");
    }
    hand().joints.push_back({name, range});
    joint_ids_.push_back(joint);
  }
  if (hand().joints.empty()) throw BadInput("the hand has no joints");
  if (hand().joint_count() > hand::kMaxJoints) {
    throw BadInput(fmt::format("the hand has {} joints, but at most {} are possible",
                               hand().joint_count(), hand::kMaxJoints));
  }
}

void Describer::read_fingers(const mjModel& model, const Anatomy& anatomy) {
  chains_ = anatomy.fingers();
  if (notes_.fingers.empty()) shorten(chains_);
  if (chains_.size() < 2) {
    throw BadInput(fmt::format(
        "{} found below {}; a hand needs two that can collide (name the palm or the tips)",
        chains_.empty() ? "no finger" : "one finger",
        model_name(model, mjOBJ_BODY, anatomy.palm())));
  }
  if (chains_.size() > hand::kMaxFingers) {
    throw BadInput(fmt::format("the hand has {} fingers, but at most {} are possible",
                               chains_.size(), hand::kMaxFingers));
  }
  for (const Chain& chain : chains_) {
    hand::Finger finger{chain.name, -1, {}};
    int jointed = chain.tip;  // the body whose joint moves the tip
    while (jointed > anatomy.root() && model.body_jntnum[jointed] == 0) {
      jointed = model.body_parentid[jointed];
    }
    Eigen::Isometry3d T_jointed_tip = Eigen::Isometry3d::Identity();
    for (int body = chain.tip; body != jointed; body = model.body_parentid[body]) {
      T_jointed_tip = pose3(model.body_pos + 3 * body, model.body_quat + 4 * body) * T_jointed_tip;
    }
    fit_surface(model, chain.tip, T_jointed_tip.inverse().translation(), notes_.tip_shape, finger);
    hand().fingers.push_back(finger);
  }
}

void Describer::read_couplings(const mjModel& model) { mimics_ = mimic_joints(model, file_); }

bool Describer::on_chain(int joint, const Chain& chain, const mjModel& model) const {
  const int body = model.jnt_bodyid[joint_ids_[static_cast<std::size_t>(joint)]];
  return std::find(chain.bodies.begin(), chain.bodies.end(), body) != chain.bodies.end();
}

void Describer::add_drives(const mjModel& model) {
  for (int joint = 0; joint < hand().joint_count(); ++joint) {
    const hand::Joint& one = hand().joints[static_cast<std::size_t>(joint)];
    const auto follows = [&](const MimicJoint& mimic) { return mimic.joint == one.name; };
    if (std::any_of(mimics_.begin(), mimics_.end(), follows)) continue;
    hand::Actuator actuator;
    actuator.name = one.name;
    actuator.joints = {{.joint = joint}};
    actuator.command = one.range;
    for (const MimicJoint& mimic : mimics_) {
      if (mimic.leader != one.name) continue;
      actuator.joints.push_back({.joint = hand().joint(mimic.joint),
                                 .gear = 0,
                                 .share = mimic.ratio,
                                 .offset = mimic.offset});
    }
    for (std::size_t finger = 0; finger < chains_.size(); ++finger) {
      if (on_chain(joint, chains_[finger], model)) actuator.finger = static_cast<int>(finger);
    }
    const double limit = torque_limit(model, joint_ids_[static_cast<std::size_t>(joint)]);
    actuator.max_torque = notes_.max_torque > 0 ? notes_.max_torque
                          : limit > 0           ? limit
                                                : kUsualTorque;
    const double middle = one.range.high + one.range.low;
    const double width = one.range.high - one.range.low;
    if (actuator.finger >= 0 && std::abs(middle) > kOneSided * width) {
      actuator.closing = middle > 0 ? 1 : -1;
    }
    hand().actuators.push_back(actuator);
  }
}

/// Puts the fingertips in and reads links, with the root at the mount.
void Describer::measure(const Anatomy& anatomy, const mjModel& model) {
  for (int finger = 0; finger < hand().finger_count(); ++finger) {
    const Chain& chain = chains_[static_cast<std::size_t>(finger)];
    put_tip(*spec_, model_name(model, mjOBJ_BODY, chain.tip), tip_geom(hand(), finger),
            hand().fingers[static_cast<std::size_t>(finger)]);
  }
  place_root(*spec_, hand().file);
  const ModelHandle fitted = compile(*spec_);
  std::vector<int> tips;
  for (int finger = 0; finger < hand().finger_count(); ++finger) {
    tips.push_back(find_id(*fitted, mjOBJ_GEOM, tip_geom(hand(), finger)));
  }
  const auto joint_of = [&](const std::string& name) {
    return NamedJoint{hand().joint(name), 1.0};
  };
  read_links(*fitted, find_id(*fitted, mjOBJ_BODY, hand().file.root),
             model_name(model, mjOBJ_BODY, anatomy.palm()), joint_of, tips, hand());
}

/// Fingers so far on their way to closed, the other joints in the middle of their ranges.
hand::ActuatorVector Describer::posture(double share) const {
  const hand::Description& hand = result_.hand;
  hand::ActuatorVector positions(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& one = hand.actuators[static_cast<std::size_t>(i)];
    const double end = one.closing > 0 ? one.command.high : one.command.low;
    const double start = std::clamp(0.0, one.command.low, one.command.high);
    positions[i] = one.closing == 0 ? 0.5 * (one.command.low + one.command.high)
                                    : start + share * (end - start);
  }
  return positions;
}

std::vector<Eigen::Vector3d> Describer::tips_at(double share) const {
  return fingertips(result_.hand, posture(share));
}

/// The finger that closes against the others: it points and moves least like them.
void Describer::find_thumb() {
  if (!notes_.thumb.empty()) {
    hand().thumb = named_thumb();
    return;
  }
  const auto from = tips_at(0.1), to = tips_at(kHalf + 0.2);
  const auto T = hand::forward_kinematics(hand(), hand::joints_in_free_flexion(hand(), posture(0)));
  std::vector<Eigen::Vector3d> ways, rays;
  for (std::size_t i = 0; i < from.size(); ++i) {
    ways.push_back((to[i] - from[i]).normalized());
    int link = hand().fingers[i].link;
    while (hand().links[static_cast<std::size_t>(link)].parent != hand().palm &&
           hand().links[static_cast<std::size_t>(link)].parent >= 0) {
      link = hand().links[static_cast<std::size_t>(link)].parent;
    }
    rays.push_back((from[i] - T[static_cast<std::size_t>(link)].translation()).normalized());
  }
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ways.size(); ++i) {
    double alike = 0;
    for (std::size_t j = 0; j < ways.size(); ++j) {
      if (j != i) alike += ways[i].dot(ways[j]) + rays[i].dot(rays[j]);
    }
    if (alike >= least) continue;
    least = alike;
    hand().thumb = static_cast<int>(i);
  }
  guess(fmt::format("{} closes against the other fingers",
                    hand().fingers[static_cast<std::size_t>(hand().thumb)].name));
}

int Describer::named_thumb() const {
  const auto& fingers = result_.hand.fingers;
  const auto named = std::ranges::find(fingers, notes_.thumb, &hand::Finger::name);
  if (named != fingers.end()) return static_cast<int>(named - fingers.begin());
  std::vector<std::string> names;
  for (const hand::Finger& finger : fingers) names.push_back(finger.name);
  throw BadInput(
      fmt::format("thumb = '{}' is none of the fingers: {}", notes_.thumb, fmt::join(names, ", ")));
}

void Describer::place_mount() {
  hand().file.T_mount_root = notes_.has_mount ? given_mount(notes_) : derived_mount();
  hand().links.front().T_parent_link = hand().file.T_mount_root;
}

/// Palm down, fingers along +x, its origin between the half closed fingertips.
Eigen::Isometry3d Describer::derived_mount() {
  const auto open = tips_at(0.1), closed = tips_at(kHalf + 0.2);
  const auto half = tips_at(kHalf);
  const auto thumb = static_cast<std::size_t>(hand().thumb);
  Eigen::Vector3d ray = Eigen::Vector3d::Zero(), way = ray, middle = ray;
  const Eigen::Vector3d palm =
      hand::forward_kinematics(
          hand(),
          hand::joints_in_free_flexion(hand(), posture(0)))[static_cast<std::size_t>(hand().palm)]
          .translation();
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (i == thumb) continue;
    ray += (open[i] - palm).normalized();
    way += closed[i] - open[i];
    middle += half[i] / static_cast<double>(open.size() - 1);
  }
  const Eigen::Vector3d origin = 0.5 * (middle + half[thumb]);
  // Where the fingers close against one another rather than onto a palm, they point down.
  const Eigen::Vector3d thumb_way = closed[thumb] - open[thumb];
  const bool gripper = way.normalized().dot(thumb_way.normalized()) < -0.7 &&
                       (open[thumb] - palm).normalized().dot(ray.normalized()) > 0.5;
  Eigen::Matrix3d R;  // columns: the mount's axes in the root's frame
  const Eigen::Vector3d z =
      gripper ? Eigen::Vector3d(-ray.normalized())
              : Eigen::Vector3d(-(way - way.dot(ray.normalized()) * ray.normalized()).normalized());
  const Eigen::Vector3d along = gripper ? Eigen::Vector3d(way) : Eigen::Vector3d(ray);
  const Eigen::Vector3d x = (along - along.dot(z) * z).normalized();
  R << x, z.cross(x), z;
  Eigen::Isometry3d T_root_mount = Eigen::Isometry3d::Identity();
  T_root_mount.linear() = R;
  T_root_mount.translation() = origin;
  if (gripper) {
    guess("the fingers point down from the mount");
  } else {
    guess("the palm faces down from the mount");
  }
  return T_root_mount.inverse();
}

void Describer::set_gains(const mjModel& model) {
  const auto joints = hand::joints_in_free_flexion(hand(), posture(kHalf));
  const auto T = hand::forward_kinematics(hand(), joints);
  for (hand::Actuator& one : hand().actuators) {
    if (one.finger >= 0) {
      const hand::Finger& finger = hand().fingers[static_cast<std::size_t>(one.finger)];
      const auto J = hand::jacobian(hand(), joints, finger.link, finger.tip.b);
      Eigen::Vector3d moved = Eigen::Vector3d::Zero();
      for (const auto& driven : one.joints) moved += driven.share * J.col(driven.joint).tail<3>();
      one.lever = std::max(0.01, moved.norm());
    } else {
      one.lever = 0.18;
    }
    one.stiffness = std::clamp(kTipStiffness * one.lever * one.lever, kMinStiffness, kMaxStiffness);
    one.armature = one.stiffness / (kNaturalFrequency * kNaturalFrequency);
    const int dof =
        model.jnt_dofadr[joint_ids_[static_cast<std::size_t>(one.joints.front().joint)]];
    const double own = model.dof_M0[dof];
    one.damping = 2 * std::sqrt(one.stiffness * (one.armature + own));
  }
  guess(fmt::format("servos of {:.0f} N/m at the fingertip, critically damped", kTipStiffness));
}

/// Links of the hand that overlap wherever it moves may go on doing so.
void Describer::exclude_overlaps() {
  place_root(*spec_, hand().file);
  const ModelHandle model = compile(*spec_);
  std::vector<hand::JointVector> everywhere;
  for (const double share : {0.0, 0.25, 0.5}) {
    everywhere.push_back(hand::joints_in_free_flexion(hand(), posture(share)));
  }
  hand().file.overlapping = overlapping_links(*model, hand(), everywhere);
  for (const auto& [one, other] : hand().file.overlapping) {
    problem(fmt::format("links {} and {} overlap in every posture", one, other),
            "they are let pass through one another; exclude the pair in the file");
  }
}

}  // namespace

DescribedHand describe_hand(const std::filesystem::path& file, const HandNotes& notes) {
  try {
    return Describer(file, notes).run();
  } catch (const BadInput& error) {
    const std::string what = error.what();
    if (what.find(file.string()) != std::string::npos) throw;
    throw BadInput(fmt::format("{}: {}", file.string(), what));
  }
}

}  // namespace palpate::simulation
