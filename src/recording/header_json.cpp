// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "recording/matrix_json.hpp"
#include "recording/record_json.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

constexpr double kUsualLinkError = 0.002;  // m, of recordings that do not say

constexpr double kHeaderRounding = 1e-9;

double radius_from_json(const json& part) {
  return plausible_from_json(part.at("radius"), 0, kMaxRadius, "a radius");
}

/// @throws BadInput unless low <= value < high
int index_from_json(const json& value, int low, std::size_t high, const char* what) {
  const auto index = value.get<std::int64_t>();
  if (index < low || index >= static_cast<std::int64_t>(high)) {
    throw BadInput(fmt::format("{} {} is not in {}..{}", what, index, low,
                               static_cast<std::int64_t>(high) - 1));
  }
  return static_cast<int>(index);
}

json object_to_json(const geometry::KnownObject& object) {
  json stable_poses = json::array(), symmetries = json::array();
  for (const auto& stable_pose : object.stable_poses) {
    stable_poses.push_back({{"R_table_object", matrix_to_json(stable_pose.R_table_object)},
                            {"height", stable_pose.height},
                            {"probability", stable_pose.probability}});
  }
  for (const auto& R : object.symmetries) symmetries.push_back(matrix_to_json(R));
  return {{"name", object.name},
          {"T_mesh_object", pose_to_json(object.T_mesh_object)},
          {"mass", object.mass},
          {"volume", object.mass_properties.volume},
          {"centroid", matrix_to_json(object.mass_properties.centroid)},
          {"inertia", matrix_to_json(object.mass_properties.inertia)},
          {"stances", stable_poses},
          {"symmetries", symmetries},
          {"repairs", object.repairs}};
}

geometry::KnownObject object_from_json(const json& j) {
  geometry::KnownObject object;
  object.name = j.at("name").get<std::string>();
  object.T_mesh_object = pose_from_json(j.at("T_mesh_object"));
  object.mass = plausible_from_json(j.at("mass"), 0, kMaxMass, "a mass");
  object.mass_properties.volume = plausible_from_json(j.at("volume"), 0, kMaxMass, "a volume");
  object.mass_properties.centroid = vector_from_json(j.at("centroid"));
  object.mass_properties.inertia = matrix_from_json<Eigen::Matrix3d>(j.at("inertia"));
  for (const auto& stable_pose : j.at("stances")) {
    object.stable_poses.push_back(
        {rotation_from_json(stable_pose.at("R_table_object")),
         plausible_from_json(stable_pose.at("height"), 0, kMaxLength, "a height"),
         plausible_from_json(stable_pose.at("probability"), 0, 1 + kHeaderRounding,
                             "a probability")});
  }
  for (const auto& R : j.at("symmetries")) {
    object.symmetries.push_back(rotation_from_json(R));
  }
  object.repairs = j.at("repairs").get<std::vector<std::string>>();
  return object;
}

json hand_to_json(const hand::HandModel& hand) {
  json links = json::array(), tips = json::array(), spheres = json::array();
  for (const auto& link : hand.links) {
    links.push_back({{"name", link.name},
                     {"parent", link.parent},
                     {"T_parent_link", pose_to_json(link.T_parent_link)},
                     {"axis", matrix_to_json(link.axis)},
                     {"joint", link.joint}});
  }
  for (const auto& tip : hand.tips) {
    tips.push_back(
        {{"a", matrix_to_json(tip.a)}, {"b", matrix_to_json(tip.b)}, {"radius", tip.radius}});
  }
  for (const auto& sphere : hand.spheres) {
    spheres.push_back({{"link", sphere.link},
                       {"center", matrix_to_json(sphere.center)},
                       {"radius", sphere.radius}});
  }
  return {{"links", links}, {"palm", hand.palm},  {"distal", hand.distal},
          {"tips", tips},   {"spheres", spheres}, {"link_error", hand.kinematic_error}};
}

hand::Link link_from_json(const json& j, std::size_t links_before) {
  return {.name = j.at("name").get<std::string>(),
          .parent = index_from_json(j.at("parent"), -1, links_before, "parent link"),
          .T_parent_link = pose_from_json(j.at("T_parent_link")),
          .axis = vector_from_json(j.at("axis")),
          .joint = index_from_json(j.at("joint"), -1, hand::kJoints, "joint")};
}

hand::HandModel hand_from_json(const json& j) {
  hand::HandModel hand;
  for (const auto& link : j.at("links")) {
    hand.links.push_back(link_from_json(link, hand.links.size()));
  }
  const std::size_t links = hand.links.size();
  hand.palm = index_from_json(j.at("palm"), -1, links, "palm link");
  for (std::size_t finger = 0; finger < hand::kFingers; ++finger) {
    const json& tip = j.at("tips").at(finger);
    hand.distal[finger] = index_from_json(j.at("distal").at(finger), 0, links, "distal link");
    hand.tips[finger] = {vector_from_json(tip.at("a")), vector_from_json(tip.at("b")),
                         radius_from_json(tip)};
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

}  // namespace

json to_json(const Header& header) {
  json j = {{"program_version", header.program_version},
            {"seed", header.seed},
            {"config_toml", header.config_toml},
            {"object", object_to_json(header.object)},
            {"hand", hand_to_json(header.hand)}};
  if (header.own_errors) j["own_errors"] = true;
  return j;
}

Header header_from_json(const json& j) {
  return {.program_version = j.at("program_version").get<std::string>(),
          .seed = j.at("seed").get<std::uint64_t>(),
          .object = object_from_json(j.at("object")),
          .hand = hand_from_json(j.at("hand")),
          .config_toml = j.at("config_toml").get<std::string>(),
          .own_errors = j.value("own_errors", false)};
}

}  // namespace palpate::recording
