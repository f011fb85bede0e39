// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "recording/hand_json.hpp"
#include "recording/matrix_json.hpp"
#include "recording/record_json.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

constexpr double kHeaderRounding = 1e-9;

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
          {"stable_poses", stable_poses},
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
  for (const auto& stable_pose : j.at(j.contains("stances") ? "stances" : "stable_poses")) {
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

}  // namespace

json to_json(const RecordingHeader& header) {
  json j = {{"program_version", header.program_version},
            {"seed", header.seed},
            {"config_toml", header.config_toml},
            {"object", object_to_json(header.object)},
            {"hand", hand_to_json(header.hand)}};
  if (header.sensor_reported_errors) j["sensor_reported_errors"] = true;
  return j;
}

RecordingHeader header_from_json(const json& j) {
  return {.program_version = j.at("program_version").get<std::string>(),
          .seed = j.at("seed").get<std::uint64_t>(),
          .object = object_from_json(j.at("object")),
          .hand = hand_from_json(j.at("hand")),
          .config_toml = j.at("config_toml").get<std::string>(),
          .sensor_reported_errors =
              j.value("own_errors", false) || j.value("sensor_reported_errors", false)};
}

}  // namespace palpate::recording
