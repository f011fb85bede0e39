// SPDX-License-Identifier: Apache-2.0
#include "recording/hand_json.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "recording/matrix_json.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

constexpr double kUsualLinkError = 0.002;  // m, of recordings that do not say

/// @throws BadInput unless low <= value < high
int index_from_json(const json& value, int low, std::size_t high, const char* what) {
  if (!value.is_number_integer()) {
    throw BadInput(fmt::format("{} {} is not a whole number", what, value.dump()));
  }
  const auto index = value.get<std::int64_t>();
  if (index < low || index >= static_cast<std::int64_t>(high)) {
    throw BadInput(fmt::format("{} {} is not in {}..{}", what, index, low,
                               static_cast<std::int64_t>(high) - 1));
  }
  return static_cast<int>(index);
}

double angle_from_json(const json& value, const char* what) {
  return plausible_from_json(value, -kMaxAngle, kMaxAngle, what);
}

json range_to_json(const hand::Range& range) { return {range.low, range.high}; }

hand::Range range_from_json(const json& j) {
  const hand::Range range{angle_from_json(j.at(0), "a range"), angle_from_json(j.at(1), "a range")};
  if (range.low > range.high) {
    throw BadInput(fmt::format("a range goes from {} to {}", range.low, range.high));
  }
  return range;
}

/// One value an actuator; empty where the hand has no such posture.
hand::ActuatorVector angles_from_json(const json& j, int actuators) {
  if (!j.is_array() || (!j.empty() && j.size() != static_cast<std::size_t>(actuators))) {
    throw BadInput(
        fmt::format("a posture of {} values, the hand has {} actuators", j.size(), actuators));
  }
  hand::ActuatorVector angles(static_cast<Eigen::Index>(j.size()));
  for (std::size_t i = 0; i < j.size(); ++i) {
    angles[static_cast<Eigen::Index>(i)] = angle_from_json(j[i], "an angle of a posture");
  }
  return angles;
}

json attitude_to_json(const hand::Attitude& attitude) { return {attitude.pitch, attitude.roll}; }

hand::Attitude attitude_from_json(const json& j) {
  return {angle_from_json(j.at(0), "a pitch"), angle_from_json(j.at(1), "a roll")};
}

std::vector<hand::Attitude> attitudes_from_json(const json& j) {
  std::vector<hand::Attitude> attitudes;
  for (const json& one : j) attitudes.push_back(attitude_from_json(one));
  return attitudes;
}

json attitudes_to_json(const std::vector<hand::Attitude>& attitudes) {
  json result = json::array();
  for (const auto& attitude : attitudes) result.push_back(attitude_to_json(attitude));
  return result;
}

Eigen::Vector2d offset_from_json(const json& j) {
  return {plausible_from_json(j.at(0), -kMaxLength, kMaxLength, "an offset"),
          plausible_from_json(j.at(1), -kMaxLength, kMaxLength, "an offset")};
}

json preshape_to_json(const hand::Preshape& preshape) {
  return {{"open", matrix_to_json(preshape.open)},
          {"closed", matrix_to_json(preshape.closed)},
          {"contact_torque", matrix_to_json(preshape.contact_torque)},
          {"attitudes", attitudes_to_json(preshape.attitudes)},
          {"offset", matrix_to_json(preshape.offset)},
          {"height", preshape.height}};
}

hand::Preshape preshape_from_json(const json& j, int actuators) {
  return {.open = angles_from_json(j.at("open"), actuators),
          .closed = angles_from_json(j.at("closed"), actuators),
          .contact_torque = angles_from_json(j.at("contact_torque"), actuators),
          .attitudes = attitudes_from_json(j.at("attitudes")),
          .offset = offset_from_json(j.at("offset")),
          .height = plausible_from_json(j.at("height"), 0, kMaxLength, "a height")};
}

json postures_to_json(const hand::Postures& postures) {
  json pointing = json::array();
  for (const auto& one : postures.pointing) {
    pointing.push_back({{"finger", one.finger},
                        {"positions", matrix_to_json(one.positions)},
                        {"attitude", attitude_to_json(one.attitude)}});
  }
  return {{"flat",
           {{"positions", matrix_to_json(postures.flat.positions)},
            {"attitude", attitude_to_json(postures.flat.attitude)},
            {"center", matrix_to_json(postures.flat.center)}}},
          {"pointing", pointing},
          {"stretched", matrix_to_json(postures.stretched)},
          {"folded", matrix_to_json(postures.folded)},
          {"released", matrix_to_json(postures.released)},
          {"top", preshape_to_json(postures.top)},
          {"side", preshape_to_json(postures.side)},
          {"far_attitudes", attitudes_to_json(postures.far_attitudes)}};
}

hand::Postures postures_from_json(const json& j, const hand::Description& hand) {
  const int actuators = hand.actuator_count();
  hand::Postures postures;
  const json& flat = j.at("flat");
  postures.flat = {angles_from_json(flat.at("positions"), actuators),
                   attitude_from_json(flat.at("attitude")), offset_from_json(flat.at("center"))};
  for (const json& one : j.at("pointing")) {
    postures.pointing.push_back(
        {index_from_json(one.at("finger"), 0, hand.fingers.size(), "a pointing finger"),
         angles_from_json(one.at("positions"), actuators), attitude_from_json(one.at("attitude"))});
  }
  postures.stretched = angles_from_json(j.at("stretched"), actuators);
  postures.folded = angles_from_json(j.at("folded"), actuators);
  postures.released = angles_from_json(j.at("released"), actuators);
  postures.top = preshape_from_json(j.at("top"), actuators);
  postures.side = preshape_from_json(j.at("side"), actuators);
  postures.far_attitudes = attitudes_from_json(j.at("far_attitudes"));
  return postures;
}

json actuators_to_json(const hand::Description& hand) {
  json actuators = json::array();
  for (const hand::Actuator& actuator : hand.actuators) {
    json driven = json::array();
    for (const hand::DrivenJoint& one : actuator.joints) {
      driven.push_back(
          {{"joint", one.joint}, {"gear", one.gear}, {"share", one.share}, {"offset", one.offset}});
    }
    actuators.push_back({{"name", actuator.name},
                         {"joints", driven},
                         {"coupled", actuator.coupling.has_value()},
                         {"finger", actuator.finger},
                         {"stiffness", actuator.stiffness},
                         {"range", range_to_json(actuator.command)},
                         {"max_torque", actuator.max_torque},
                         {"closing", actuator.closing},
                         {"lever", actuator.lever},
                         {"bend", range_to_json(actuator.bend)}});
  }
  return actuators;
}

hand::Actuator actuator_from_json(const json& j, const hand::Description& hand) {
  hand::Actuator actuator;
  actuator.name = j.at("name").get<std::string>();
  for (const json& one : j.at("joints")) {
    actuator.joints.push_back({index_from_json(one.at("joint"), 0, hand.joints.size(), "a joint"),
                               finite_from_json(one.at("gear")), finite_from_json(one.at("share")),
                               finite_from_json(one.at("offset"))});
  }
  if (j.at("coupled").get<bool>()) {
    if (actuator.joints.size() != 2) {
      throw BadInput(
          fmt::format("{} couples {} joints, not 2", actuator.name, actuator.joints.size()));
    }
    actuator.coupling.emplace();
  }
  actuator.finger = index_from_json(j.at("finger"), -1, hand.fingers.size(), "a finger");
  actuator.stiffness = plausible_from_json(j.at("stiffness"), 1e-9, 1e9, "a stiffness");
  actuator.command = range_from_json(j.at("range"));
  actuator.max_torque = plausible_from_json(j.at("max_torque"), 0, kMaxTorque, "a torque");
  actuator.closing = plausible_from_json(j.at("closing"), -1e3, 1e3, "a speed of closing");
  actuator.lever = plausible_from_json(j.at("lever"), 0, kMaxLength, "a lever");
  actuator.bend = range_from_json(j.at("bend"));
  return actuator;
}

hand::Link link_from_json(const json& j, std::size_t links_before, std::size_t joints) {
  constexpr double kUnit = 1e-6;
  hand::Link link{.name = j.at("name").get<std::string>(),
                  .parent = index_from_json(j.at("parent"), -1, links_before, "parent link"),
                  .T_parent_link = pose_from_json(j.at("T_parent_link")),
                  .axis = vector_from_json(j.at("axis")),
                  .joint = index_from_json(j.at("joint"), -1, joints, "joint")};
  if (link.joint >= 0) plausible(link.axis.norm(), 1 - kUnit, 1 + kUnit, "the length of an axis");
  return link;
}

double radius_from_json(const json& part) {
  return plausible_from_json(part.at("radius"), 0, kMaxRadius, "a radius");
}

hand::TipCapsule tip_from_json(const json& j) {
  return {vector_from_json(j.at("a")), vector_from_json(j.at("b")), radius_from_json(j)};
}

json hull_to_json(const hand::TipHull& hull) {
  json core = json::array();
  for (const Eigen::Vector3d& p : hull.core) core.push_back(matrix_to_json(p));
  return {{"core", core}, {"radius", hull.radius}};
}

hand::TipHull hull_from_json(const json& j) {
  hand::TipHull hull{{}, radius_from_json(j)};
  for (const json& p : j.at("core")) hull.core.push_back(vector_from_json(p));
  if (hull.core.size() < 4 || !(hull.radius > 0)) {
    throw BadInput(fmt::format("a fingertip's hull of {} points and a radius of {} m",
                               hull.core.size(), hull.radius));
  }
  return hull;
}

/// Joints, actuators and postures; of an older recording, those of the Shadow hand.
hand::Description drives_from_json(const json& j) {
  if (!j.contains("actuators")) return hand::shadow_hand();
  hand::Description hand;
  hand.name = j.at("name").get<std::string>();
  for (const json& joint : j.at("joints")) {
    hand.joints.push_back(
        {joint.at("name").get<std::string>(), range_from_json(joint.at("range"))});
  }
  for (const json& name : j.at("fingers"))
    hand.fingers.push_back({name.get<std::string>(), -1, {}});
  if (hand.joints.size() > hand::kMaxJoints || hand.fingers.size() > hand::kMaxFingers) {
    throw BadInput(fmt::format("a hand of {} joints and {} fingers; at most {} and {} can be",
                               hand.joints.size(), hand.fingers.size(), hand::kMaxJoints,
                               hand::kMaxFingers));
  }
  if (hand.joints.empty() || j.at("actuators").empty()) {
    throw BadInput(fmt::format("a hand of {} joints and {} actuators; it needs both",
                               hand.joints.size(), j.at("actuators").size()));
  }
  for (const json& actuator : j.at("actuators")) {
    hand.actuators.push_back(actuator_from_json(actuator, hand));
  }
  if (hand.actuators.size() > hand::kMaxJoints) {
    throw BadInput(fmt::format("a hand of {} actuators", hand.actuators.size()));
  }
  hand.thumb = index_from_json(j.at("thumb"), 0, hand.fingers.size(), "the thumb");
  hand.postures = postures_from_json(j.at("postures"), hand);
  return hand;
}

}  // namespace

json hand_to_json(const hand::Description& hand) {
  json links = json::array(), tips = json::array(), spheres = json::array();
  json joints = json::array(), fingers = json::array(), distal = json::array();
  for (const auto& link : hand.links) {
    links.push_back({{"name", link.name},
                     {"parent", link.parent},
                     {"T_parent_link", pose_to_json(link.T_parent_link)},
                     {"axis", matrix_to_json(link.axis)},
                     {"joint", link.joint}});
  }
  for (const auto& finger : hand.fingers) {
    fingers.push_back(finger.name);
    distal.push_back(finger.link);
    tips.push_back({{"a", matrix_to_json(finger.tip.a)},
                    {"b", matrix_to_json(finger.tip.b)},
                    {"radius", finger.tip.radius}});
    if (finger.hull) tips.back()["hull"] = hull_to_json(*finger.hull);
  }
  for (const auto& sphere : hand.spheres) {
    spheres.push_back({{"link", sphere.link},
                       {"center", matrix_to_json(sphere.center)},
                       {"radius", sphere.radius}});
  }
  for (const auto& joint : hand.joints) {
    joints.push_back({{"name", joint.name}, {"range", range_to_json(joint.range)}});
  }
  return {
      {"name", hand.name},  {"joints", joints},    {"actuators", actuators_to_json(hand)},
      {"fingers", fingers}, {"thumb", hand.thumb}, {"postures", postures_to_json(hand.postures)},
      {"links", links},     {"palm", hand.palm},   {"distal", distal},
      {"tips", tips},       {"spheres", spheres},  {"link_error", hand.kinematic_error}};
}

hand::Description hand_from_json(const json& j) {
  hand::Description hand = drives_from_json(j);
  for (const auto& link : j.at("links")) {
    hand.links.push_back(link_from_json(link, hand.links.size(), hand.joints.size()));
  }
  const std::size_t links = hand.links.size();
  hand.palm = index_from_json(j.at("palm"), -1, links, "palm link");
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    hand.fingers[finger].link = index_from_json(j.at("distal").at(finger), 0, links, "distal link");
    const json& tip = j.at("tips").at(finger);
    hand.fingers[finger].tip = tip_from_json(tip);
    if (tip.contains("hull")) hand.fingers[finger].hull = hull_from_json(tip.at("hull"));
  }
  for (const auto& sphere : j.at("spheres")) {
    hand.spheres.push_back({index_from_json(sphere.at("link"), 0, links, "link of a sphere"),
                            vector_from_json(sphere.at("center")), radius_from_json(sphere)});
  }
  hand.kinematic_error = j.contains("link_error")
                             ? plausible_from_json(j.at("link_error"), 0, kMaxRadius, "link_error")
                             : kUsualLinkError;
  return hand;
}

}  // namespace palpate::recording
