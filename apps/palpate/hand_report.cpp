// SPDX-License-Identifier: Apache-2.0
#include "hand_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/hand/kinematics.hpp"

namespace palpate::app {
namespace {

const std::string& joint_name(const hand::Description& hand, int joint) {
  return hand.joints[static_cast<std::size_t>(joint)].name;
}

/// Links from the palm, which is left out, to a fingertip.
std::vector<int> links_of(const hand::Description& hand, int finger) {
  std::vector<int> links;
  int link = hand.fingers[static_cast<std::size_t>(finger)].link;
  for (; link >= 0 && link != hand.palm; link = hand.links[static_cast<std::size_t>(link)].parent) {
    links.insert(links.begin(), link);
  }
  return links;
}

/// Joints that move the finger and no other one, from the palm on.
std::vector<std::string> joints_of(const hand::Description& hand, int finger) {
  std::vector<std::string> names;
  for (const int link : links_of(hand, finger)) {
    bool shared = false;
    for (int other = 0; other < hand.finger_count(); ++other) {
      shared |= other != finger && std::ranges::count(links_of(hand, other), link) > 0;
    }
    const int joint = hand.links[static_cast<std::size_t>(link)].joint;
    if (joint >= 0 && !shared) names.push_back(joint_name(hand, joint));
  }
  return names;
}

const std::string& tip_link(const hand::Description& hand, const hand::Finger& finger) {
  return hand.links[static_cast<std::size_t>(finger.link)].name;
}

/// A fingertip's surface in words.
std::string shape_of(const hand::Finger& finger) {
  if (!finger.hull) return fmt::format("capsule, radius {:.1f} mm", 1e3 * finger.tip.radius);
  return fmt::format("convex, {} corners", finger.hull->core.size());
}

nlohmann::json tip_json(const hand::Description& hand, const hand::Finger& finger) {
  nlohmann::json tip = {{"link", tip_link(hand, finger)},
                        {"shape", finger.hull ? "hull" : "capsule"},
                        {"radius", finger.tip.radius},
                        {"length", (finger.tip.b - finger.tip.a).norm()}};
  if (finger.hull) {
    tip["corners"] = finger.hull->core.size();
    tip["edge_radius"] = finger.hull->radius;
  }
  return tip;
}

/// Roll, pitch and yaw, deg.
Eigen::Vector3d rpy_of(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d rpy(std::atan2(R(2, 1), R(2, 2)),
                            std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
                            std::atan2(R(1, 0), R(0, 0)));
  return 180 / std::numbers::pi * rpy;
}

/// The pose of the root in the mount's frame, as a TOML file has it: m, deg.
nlohmann::json mount_json(const hand::Description& hand) {
  const Eigen::Vector3d p = hand.file.T_mount_root.translation();
  const Eigen::Vector3d rpy = rpy_of(hand.file.T_mount_root.linear());
  return {{"x", p.x()},      {"y", p.y()},       {"z", p.z()},
          {"roll", rpy.x()}, {"pitch", rpy.y()}, {"yaw", rpy.z()}};
}

const std::string& palm_name(const hand::Description& hand) {
  return hand.links[static_cast<std::size_t>(hand.palm)].name;
}

/// Joints that follow an actuator's first.
nlohmann::json followers_json(const hand::Description& hand, const hand::Actuator& actuator) {
  auto followers = nlohmann::json::array();
  for (std::size_t i = 1; i < actuator.joints.size() && !actuator.coupling; ++i) {
    const auto& [joint, gear, share, offset] = actuator.joints[i];
    followers.push_back(
        {{"joint", joint_name(hand, joint)}, {"multiplier", share}, {"offset", offset}});
  }
  return followers;
}

/// What follows an actuator's first joint, as "b = 0.8 a +0.1".
std::string followers_text(const hand::Description& hand, const hand::Actuator& actuator) {
  std::string text;
  for (std::size_t i = 1; i < actuator.joints.size() && !actuator.coupling; ++i) {
    const auto& [joint, gear, share, offset] = actuator.joints[i];
    text += fmt::format("  {} = ", joint_name(hand, joint));
    if (share != 0) text += fmt::format("{:.3g} {}", share, actuator.name);
    if (share == 0 || offset != 0) text += fmt::format("{}{:+.3g}", share == 0 ? "" : " ", offset);
  }
  return text;
}

/// The root, the palm, and where the root is in the mount's frame, as `mount` of a TOML file has
/// it.
void print_frames(const hand::Description& hand) {
  const Eigen::Vector3d p = hand.file.T_mount_root.translation();
  const Eigen::Vector3d rpy = rpy_of(hand.file.T_mount_root.linear());
  fmt::print(
      "root {}, palm {}; in the mount's frame the root is at x {:.3f} y {:.3f} z {:.3f} m, "
      "roll {:.1f} pitch {:.1f} yaw {:.1f} deg\n\n",
      hand.file.root, palm_name(hand), p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z());
}

}  // namespace

nlohmann::json hand_json(const simulation::DescribedHand& loaded) {
  const hand::Description& hand = loaded.hand;
  auto fingers = nlohmann::json::array(), actuators = nlohmann::json::array();
  auto problems = nlohmann::json::array();
  for (int i = 0; i < hand.finger_count(); ++i) {
    const hand::Finger& finger = hand.fingers[static_cast<std::size_t>(i)];
    fingers.push_back({{"name", finger.name},
                       {"thumb", i == hand.thumb},
                       {"joints", joints_of(hand, i)},
                       {"tip", tip_json(hand, finger)}});
  }
  for (const hand::Actuator& actuator : hand.actuators) {
    actuators.push_back({{"name", actuator.name},
                         {"range", {actuator.command.low, actuator.command.high}},
                         {"stiffness", actuator.stiffness},
                         {"damping", actuator.damping},
                         {"max_torque", actuator.max_torque},
                         {"closing", actuator.closing},
                         {"followers", followers_json(hand, actuator)}});
  }
  for (const auto& problem : loaded.problems) {
    problems.push_back({{"what", problem.what}, {"hint", problem.hint}});
  }
  nlohmann::json report = {
      {"hand", hand.name},         {"root", hand.file.root},    {"palm", palm_name(hand)},
      {"mount", mount_json(hand)}, {"fingers", fingers},        {"actuators", actuators},
      {"problems", problems},      {"guesses", loaded.guesses}, {"joints", hand.joint_count()}};
  if (!loaded.failure.empty()) report["failure"] = loaded.failure;
  return report;
}

void print_hand(const simulation::DescribedHand& loaded) {
  const hand::Description& hand = loaded.hand;
  fmt::print("{}: {} fingers, {} joints, {} actuators\n\n", hand.name, hand.finger_count(),
             hand.joint_count(), hand.actuator_count());
  print_frames(hand);
  std::size_t name_width = 10, tip_width = 18, actuator_width = 22;
  for (const hand::Finger& finger : hand.fingers) {
    name_width = std::max(name_width, finger.name.size());
    tip_width = std::max(tip_width, tip_link(hand, finger).size());
  }
  for (const hand::Actuator& actuator : hand.actuators) {
    actuator_width = std::max(actuator_width, actuator.name.size());
  }
  fmt::print("{:<{}} {:<{}} {:<23}  {}\n", "finger", name_width, "fingertip", tip_width, "surface",
             "joints");
  for (int i = 0; i < hand.finger_count(); ++i) {
    const hand::Finger& finger = hand.fingers[static_cast<std::size_t>(i)];
    fmt::print("{:<{}} {:<{}} {:<23}  {}{}\n", finger.name, name_width, tip_link(hand, finger),
               tip_width, shape_of(finger), fmt::join(joints_of(hand, i), " "),
               i == hand.thumb ? "  (thumb)" : "");
  }
  fmt::print("\n{:<{}} {:>15} {:>12} {:>10} {:>8}\n", "actuator", actuator_width, "range (rad)",
             "P (N m/rad)", "max (N m)", "closing");
  for (const hand::Actuator& actuator : hand.actuators) {
    fmt::print("{:<{}} {:>15} {:>12.2f} {:>10.2f} {:>8.2f}{}\n", actuator.name, actuator_width,
               fmt::format("{:.2f} .. {:.2f}", actuator.command.low, actuator.command.high),
               actuator.stiffness, actuator.max_torque, actuator.closing,
               followers_text(hand, actuator));
  }
  if (!loaded.guesses.empty()) fmt::print("\nGuessed:\n");
  for (const auto& guess : loaded.guesses) fmt::print("  {}\n", guess);
  if (!loaded.problems.empty()) fmt::print("\nProblems:\n");
  for (const auto& problem : loaded.problems) {
    fmt::print("  {}: {}\n", problem.what, problem.hint);
  }
  if (loaded.problems.empty() && loaded.failure.empty()) fmt::print("\nNo problems.\n");
}

}  // namespace palpate::app
