// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/describe_hand.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "simulation/hand/anatomy.hpp"
#include "simulation/hand/closing_joints.hpp"
#include "simulation/hand/find_thumb.hpp"
#include "simulation/hand/hand_alone.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/hand/joint_drives.hpp"
#include "simulation/hand/mimic_joints.hpp"
#include "simulation/hand/model_checks.hpp"
#include "simulation/hand/mount_frame.hpp"
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

class Describer {
 public:
  Describer(const std::filesystem::path& file, const HandNotes& notes)
      : file_(file), notes_(notes) {
    std::vector<std::string> warnings;
    spec_ = parse_model(file, &warnings);
    for (const std::string& warning : warnings) {
      problem(warning, "see the file");
    }
    result_.hand.name = file.string();
    result_.hand.file.path = std::filesystem::absolute(file);
  }

  DescribedHand run() {
    result_.hand.file.root = find_root(*spec_, notes_);
    keep_hand_only(*spec_, result_.hand.file.root);
    const ModelHandle model = compile(*spec_);
    check_masses(*model);
    check_shapes(*model);
    refuse_closed_loops(*model);
    problem(left_out_tendons(*model),
            "their joints get a drive each; tie joints by an equality instead");
    if (const int joints = springs(*model); joints > 0) {
      problem(fmt::format("springs of {} joints are left out", joints), "servos hold the joints");
    }
    mimics_ = mimic_joints(*model, file_);
    const Anatomy anatomy(*model, result_.hand.file.root, notes_, mimics_);
    refuse_slides(*model, anatomy);
    read_joints(*model, anatomy);
    read_fingers(*model, anatomy);
    report_joints(*model, anatomy);
    add_drives(*model);
    problem(led_fingers(hand(), finger_of_joint_),
            "it cannot press by itself, and grasps may not hold");
    measure(anatomy, *model);
    check_size(hand());
    choose_thumb(*model);
    if (!ranges_determine_closing(hand())) set_closing();
    if (notes_.closing.empty() && reverse_if_closed_at_zero(hand())) guess("0 is the closed hand");
    place_mount();
    set_closing();
    set_gains(*model);
    if (notes_.max_torque == 0) guess(lower_torque_limits(hand()));
    exclude_overlaps();
    return std::move(result_);
  }

 private:
  hand::Description& hand() { return result_.hand; }
  void guess(std::string text) {
    if (!text.empty()) result_.guesses.push_back(std::move(text));
  }
  void problem(std::string what, std::string hint) {
    if (what.empty()) return;
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
  hand::Range range_without_limits(const mjModel& model, int joint);
  void read_fingers(const mjModel& model, const Anatomy& anatomy);
  void report_joints(const mjModel& model, const Anatomy& anatomy);
  void add_drives(const mjModel& model);
  void add_followers(hand::Actuator& actuator);
  double torque_of(const mjModel& model, int joint) const;
  void measure(const Anatomy& anatomy, const mjModel& model);
  int first_link(const mjModel& model, std::size_t finger) const;
  void choose_thumb(const mjModel& model);
  void place_mount();
  Eigen::Isometry3d derived_mount();
  void set_gains(const mjModel& model);
  void exclude_overlaps();
  int finger_of(int body) const;
  hand::ActuatorVector posture(double share) const;
  std::vector<Eigen::Vector3d> tips_at(double share) const;

  std::filesystem::path file_;
  HandNotes notes_;
  SpecHandle spec_;
  DescribedHand result_;
  std::vector<Chain> chains_;
  std::vector<int> joint_ids_;  // in the model, of the hand's joints
  std::vector<int> finger_of_joint_;
  std::vector<MimicJoint> mimics_;  // by name
};

void Describer::read_joints(const mjModel& model, const Anatomy& anatomy) {
  std::vector<std::string> stiff;
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (!anatomy.is_below(model.jnt_bodyid[joint])) continue;
    const std::string name = model_name(model, mjOBJ_JOINT, joint);
    hand::Range range{model.jnt_range[2 * joint], model.jnt_range[2 * joint + 1]};
    check_limits(name, range);
    if (!model.jnt_limited[joint] || !(range.high > range.low)) {
      range = range_without_limits(model, joint);
      check_limits(name, range);
    }
    if (range.high - range.low < kLeastBend) stiff.push_back(name);
    hand().joints.push_back({name, range});
    joint_ids_.push_back(joint);
  }
  if (!stiff.empty()) {
    problem(fmt::format("joints turn by less than {} rad: {}", kLeastBend, first_of(stiff)),
            "are their limits in radians where the file's angles are degrees?");
  }
  if (hand().joints.empty()) throw BadInput("the hand has no joints");
  if (hand().joint_count() > hand::kMaxJoints) {
    throw BadInput(fmt::format("the hand has {} joints, but at most {} are possible",
                               hand().joint_count(), hand::kMaxJoints));
  }
}

/// That of its actuator's commands, else a usual one.
hand::Range Describer::range_without_limits(const mjModel& model, int joint) {
  const mjtNum* const given = model.jnt_range + 2 * joint;
  const auto commanded = commanded_range(model, joint);
  const hand::Range range = commanded.value_or(hand::Range{0, kUsualBend});
  problem(fmt::format("{} of joint {}", given[1] < given[0] ? "reversed limits" : "no limits",
                      model_name(model, mjOBJ_JOINT, joint)),
          fmt::format("give it a range in the file; {:.3g} .. {:.3g} rad is used{}", range.low,
                      range.high, commanded ? ", the commands of its actuator" : ""));
  return range;
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

/// Says which joints are locked, and which move no finger.
void Describer::report_joints(const mjModel& model, const Anatomy& anatomy) {
  for (const MimicJoint& mimic : mimics_) {
    if (mimic.ratio != 0) continue;
    guess(fmt::format("joint {} is locked at {:.2f} rad", mimic.joint, mimic.offset));
  }
  if (!notes_.tips.empty()) return;
  std::vector<std::string> lost;
  for (const int joint : anatomy.joints_of_no_finger()) {
    lost.push_back(model_name(model, mjOBJ_JOINT, joint));
  }
  if (lost.empty()) return;
  problem(fmt::format("joints {} belong to no finger", fmt::join(lost, ", ")),
          "if they should, name every fingertip: tips = \"BODY,BODY\" in a TOML file");
}

int Describer::finger_of(int body) const {
  int finger = -1;
  for (std::size_t i = 0; i < chains_.size(); ++i) {
    if (std::ranges::count(chains_[i].bodies, body) > 0) finger = static_cast<int>(i);
  }
  return finger;
}

void Describer::add_drives(const mjModel& model) {
  for (const int joint : joint_ids_) finger_of_joint_.push_back(finger_of(model.jnt_bodyid[joint]));
  for (int joint = 0; joint < hand().joint_count(); ++joint) {
    const hand::Joint& one = hand().joints[static_cast<std::size_t>(joint)];
    const auto follows = [&](const MimicJoint& mimic) { return mimic.joint == one.name; };
    if (std::any_of(mimics_.begin(), mimics_.end(), follows)) continue;
    hand::Actuator actuator;
    actuator.name = one.name;
    actuator.joints = {{.joint = joint}};
    actuator.command = one.range;
    guess(limit_by_commands(model, joint_ids_[static_cast<std::size_t>(joint)], actuator));
    const auto [low, high] = actuator.command;
    add_followers(actuator);
    actuator.finger = finger_of_joint_[static_cast<std::size_t>(joint)];
    actuator.max_torque = torque_of(model, joint);
    if (actuator.finger >= 0 && std::abs(high + low) > kOneSided * (high - low)) {
      actuator.closing = high + low > 0 ? 1 : -1;
    }
    hand().actuators.push_back(actuator);
  }
}

/// The joints that follow an actuator's first, which then goes no farther than they can.
void Describer::add_followers(hand::Actuator& actuator) {
  for (const MimicJoint& mimic : mimics_) {
    if (mimic.leader != actuator.name) continue;
    actuator.joints.push_back({.joint = hand().joint(mimic.joint),
                               .gear = 0,
                               .share = mimic.ratio,
                               .offset = mimic.offset});
  }
  const hand::Range led = range_with_followers(hand(), actuator), own = actuator.command;
  if (led.low == own.low && led.high == own.high) return;
  if (led.high - led.low < kLeastBend) {
    problem(fmt::format("the limits of the joints that follow {} leave it nothing", actuator.name),
            "compare their limits with the equality or mimic; they are ignored");
    return;
  }
  guess(fmt::format("{} moves from {:.2f} to {:.2f} rad, as far as its followers' limits allow",
                    actuator.name, led.low, led.high));
  actuator.command = led;
}

/// N m: the user's, the file's or a usual one.
double Describer::torque_of(const mjModel& model, int joint) const {
  if (notes_.max_torque > 0) return notes_.max_torque;
  const double limit = torque_limit(model, joint_ids_[static_cast<std::size_t>(joint)]);
  return limit > 0 ? limit : kUsualTorque;
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
    const double start = hand::straight_command(one);
    positions[i] = one.closing == 0 ? 0.5 * (one.command.low + one.command.high)
                                    : start + share * (hand::closed_command(one) - start);
  }
  return positions;
}

std::vector<Eigen::Vector3d> Describer::tips_at(double share) const {
  return fingertips(result_.hand, posture(share));
}

int Describer::first_link(const mjModel& model, std::size_t finger) const {
  const hand::Description& hand = result_.hand;
  const int carrier = model.body_parentid[chains_[finger].bodies.front()];
  const std::string name = model_name(model, mjOBJ_BODY, carrier);
  int link = hand.fingers[finger].link;
  while (true) {
    const int parent = hand.links[static_cast<std::size_t>(link)].parent;
    if (parent < 0 || parent == hand.palm) return link;
    if (hand.links[static_cast<std::size_t>(parent)].name == name) return link;
    link = parent;
  }
}

void Describer::choose_thumb(const mjModel& model) {
  if (!notes_.thumb.empty()) {
    hand().thumb = named_thumb(hand(), notes_.thumb);
    return;
  }
  FingerMotion motion{{}, tips_at(0.1), tips_at(kHalf + 0.2)};
  const auto T = hand::forward_kinematics(hand(), hand::joints_in_free_flexion(hand(), posture(0)));
  for (std::size_t i = 0; i < chains_.size(); ++i) {
    motion.bases.push_back(T[static_cast<std::size_t>(first_link(model, i))].translation());
  }
  hand().thumb = find_thumb(motion);
  guess(fmt::format("{} closes against the other fingers",
                    hand().fingers[static_cast<std::size_t>(hand().thumb)].name));
}

void Describer::place_mount() {
  hand().file.T_mount_root = has_mount(notes_) ? given_mount(notes_) : derived_mount();
  hand().links.front().T_parent_link = hand().file.T_mount_root;
}

Eigen::Isometry3d Describer::derived_mount() {
  const auto T = hand::forward_kinematics(hand(), hand::joints_in_free_flexion(hand(), posture(0)));
  const MountFrame frame =
      derive_mount({tips_at(0.1), tips_at(kHalf), tips_at(kHalf + 0.2)},
                   T[static_cast<std::size_t>(hand().palm)].translation(), hand().thumb);
  guess(frame.points_down ? "the fingers point down from the mount"
                          : "the palm faces down from the mount");
  return frame.T_root_mount.inverse();
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
  std::vector<hand::JointVector> everywhere;
  for (const double share : {0.0, 0.25, 0.5}) {
    everywhere.push_back(hand::joints_in_free_flexion(hand(), posture(share)));
  }
  const auto overlapping = overlapping_links(*compile(*spec_), hand(), everywhere);
  hand().file.overlapping = let_all_collide(*spec_)
                                ? overlapping_links(*compile(*spec_), hand(), everywhere)
                                : overlapping;
  if (overlapping.empty()) return;
  problem(fmt::format("links overlap in every posture: {}", first_of(overlapping)),
          "they are let pass through one another; exclude the pairs in the file");
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
