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
#include "simulation/hand/read_joints.hpp"
#include "simulation/hand/tip_capsule.hpp"

namespace palpate::simulation {
namespace {

constexpr double kUsualTorque = 1.0;  // N m, where the file names no limit
constexpr double kOneSided = 0.3;     // asymmetry of a range from which a joint flexes a finger
constexpr double kOutside = 0.005;    // m beyond a fingertip's surface at which a shape is missed
constexpr double kHalf = 0.35;        // share of the way to closed at which the hand is measured

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
    if (notes_.root.empty()) {
      problem(another_hand(*spec_, result_.hand.file.root),
              "root = \"BODY\" in a TOML file takes it");
    }
    keep_hand_only(*spec_, result_.hand.file.root);
    const ModelHandle model = compile(*spec_);
    check_shapes(*model);
    refuse_closed_loops(*model);
    problem(left_out_tendons(*model), "joints get a drive each; tie them by an equality instead");
    if (const int joints = springs(*model); joints > 0) {
      problem(fmt::format("springs of {} joints are left out", joints), "servos hold the joints");
    }
    mimics_ = mimic_joints(*model, file_);
    const Anatomy anatomy(*model, result_.hand.file.root, notes_, mimics_);
    refuse_slides(*model, anatomy);
    joint_ids_ = read_joints(*model, anatomy, result_);
    read_fingers(*model, anatomy);
    report_joints(*model, anatomy);
    add_drives(*model);
    problem(led_fingers(hand(), finger_of_joint_),
            "it cannot press by itself, and grasps may not hold");
    measure(anatomy, *model);
    check_size(hand());
    choose_thumb(*model);
    if (notes_.closing.empty()) guess(symmetric_joints(hand()));
    if (!ranges_determine_closing(hand())) set_closing();
    if (notes_.closing.empty() && reverse_if_closed_at_zero(hand())) guess("0 is the closed hand");
    place_mount();
    set_closing();
    set_gains(*model, joint_ids_, posture(kHalf), hand());
    guess(fmt::format("servos of {:.0f} N/m at the fingertip, critically damped", kTipStiffness));
    if (notes_.max_torque == 0) guess(lower_torque_limits(hand()));
    for (HandProblem& one : check_drives(*model, joint_ids_, notes_.max_torque > 0, hand())) {
      result_.problems.push_back(std::move(one));
    }
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
      simulation::set_closing(listed("closing", notes_.closing), hand());
    }
  }

  void read_fingers(const mjModel& model, const Anatomy& anatomy);
  void report_joints(const mjModel& model, const Anatomy& anatomy);
  void add_drives(const mjModel& model);
  void add_followers(hand::Actuator& actuator);
  double torque_of(const mjModel& model, int joint) const;
  void measure(const Anatomy& anatomy, const mjModel& model);
  int first_link(const mjModel& model, std::size_t finger) const;
  void choose_thumb(const mjModel& model);
  void place_mount();
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

void Describer::read_fingers(const mjModel& model, const Anatomy& anatomy) {
  chains_ = anatomy.fingers();
  if (notes_.fingers.empty()) shorten(chains_);
  if (chains_.size() < 2) {
    throw BadInput(fmt::format(
        "{} found below the palm {}; a hand needs two that can collide: root, palm or tips in a "
        "TOML file names its first body, its palm or its fingertips",
        chains_.empty() ? "no finger" : "one finger",
        model_name(model, mjOBJ_BODY, anatomy.palm())));
  }
  if (chains_.size() > hand::kMaxFingers) {
    throw BadInput(fmt::format("the hand has {} fingers, but at most {} are possible",
                               chains_.size(), hand::kMaxFingers));
  }
  std::vector<std::string> outside;
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
    const Eigen::Vector3d p_base = T_jointed_tip.inverse().translation();
    fit_surface(model, chain.tip, p_base, notes_.tip_shape, finger);
    if (const double beyond = reach_beyond(model, chain.tip, p_base, finger); beyond > kOutside) {
      outside.push_back(
          fmt::format("{} ({:.0f} mm)", model_name(model, mjOBJ_BODY, chain.tip), 1e3 * beyond));
    }
    hand().fingers.push_back(finger);
  }
  if (outside.empty()) return;
  guess(fmt::format(
      "shapes of the last links that reach beyond the fingertip's surface meet nothing: {}",
      first_of(outside)));
}

/// Says which joints are locked, and which move no finger.
void Describer::report_joints(const mjModel& model, const Anatomy& anatomy) {
  for (const MimicJoint& mimic : mimics_) {
    if (mimic.ratio != 0) continue;
    guess(fmt::format("joint {} is locked at {:.2f} rad", mimic.joint, mimic.offset));
  }
  const auto named = [&](const std::vector<int>& joints) {
    std::vector<std::string> names;
    for (const int joint : joints) names.push_back(model_name(model, mjOBJ_JOINT, joint));
    return names;
  };
  if (const auto carry = named(anatomy.joints_before_fingers()); !carry.empty()) {
    guess(
        fmt::format("joints {} carry several fingers and are held; root = \"BODY\" in a TOML file "
                    "leaves out those above it",
                    first_of(carry)));
  }
  const auto lost = named(anatomy.joints_of_no_finger());
  if (lost.empty()) return;
  if (notes_.tips.empty()) {
    problem(fmt::format("joints {} belong to no finger", fmt::join(lost, ", ")),
            "give their links something that can collide, or name every fingertip: tips = "
            "\"BODY,BODY\" in a TOML file");
  } else {
    guess(fmt::format("joints {} are beyond the fingertips or of no finger, and are held",
                      first_of(lost)));
  }
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
  std::vector<std::string> unlimited;
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
    if (actuator.max_torque == 0) {
      actuator.max_torque = kUsualTorque;
      unlimited.push_back(one.name);
    }
    if (actuator.finger >= 0 && std::abs(high + low) > kOneSided * (high - low)) {
      actuator.closing = high + low > 0 ? 1 : -1;
    }
    hand().actuators.push_back(actuator);
  }
  if (unlimited.empty()) return;
  guess(fmt::format("{} N m is the torque limit of {}, for which the file has no finite one",
                    kUsualTorque, first_of(unlimited)));
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

/// N m: the user's or the file's; 0 where there is none.
double Describer::torque_of(const mjModel& model, int joint) const {
  if (notes_.max_torque > 0) return notes_.max_torque;
  return torque_limit(model, joint_ids_[static_cast<std::size_t>(joint)]);
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
  const auto T = hand::forward_kinematics(hand(), hand::joints_in_free_flexion(hand(), posture(0)));
  const MountFrame derived =
      derive_mount({tips_at(0.1), tips_at(kHalf), tips_at(kHalf + 0.2)},
                   T[static_cast<std::size_t>(hand().palm)].translation(), hand().thumb);
  hand().file.T_mount_root = derived.T_root_mount.inverse();
  if (has_mount(notes_)) {
    hand().file.T_mount_root = given_mount(notes_);
    problem(far_from(given_mount(notes_), derived.T_root_mount.inverse()),
            "compare the pictures of `palpate hand render`; without `mount` it is derived");
  } else {
    guess(derived.points_down ? "the fingers point down from the mount"
                              : "the palm faces down from the mount");
  }
  hand().links.front().T_parent_link = hand().file.T_mount_root;
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

hand::ActuatorVector partly_closed(const hand::Description& hand, double share) {
  hand::ActuatorVector positions(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& one = hand.actuators[static_cast<std::size_t>(i)];
    const double straight = hand::straight_command(one);
    positions[i] =
        one.closing == 0 ? straight : straight + share * (hand::closed_command(one) - straight);
  }
  return positions;
}

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
