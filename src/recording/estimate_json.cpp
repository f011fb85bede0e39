// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "palpate/core/error.hpp"
#include "recording/matrix_json.hpp"
#include "recording/record_json.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

constexpr double kRounding = 1e-9;

constexpr std::array<EventKind, 3> kEventKinds = {EventKind::begin, EventKind::note,
                                                  EventKind::end};

json mode_to_json(const PoseModeRecord& mode) {
  json j = {{"T_world_object", pose_to_json(mode.T_world_object)},
            {"weight", mode.weight},
            {"covariance", matrix_to_json(mode.covariance)},
            {"free_axis", nullptr}};
  if (mode.free_axis) {
    j["free_axis"] = {{"point", matrix_to_json(mode.free_axis->point)},
                      {"direction", matrix_to_json(mode.free_axis->direction)},
                      {"extent", mode.free_axis->extent}};
    if (mode.free_axis->share) j["free_axis"]["share"] = *mode.free_axis->share;
  }
  return j;
}

PoseModeRecord mode_from_json(const json& j) {
  PoseModeRecord mode = {
      .T_world_object = pose_from_json(j.at("T_world_object")),
      .weight = plausible_from_json(j.at("weight"), 0, 1 + kRounding, "a weight"),
      .covariance = matrix_from_json<Matrix6d>(j.at("covariance")),
      .free_axis = {}};
  if (const json& axis = j.at("free_axis"); !axis.is_null()) {
    mode.free_axis = {vector_from_json(axis.at("point")), vector_from_json(axis.at("direction")),
                      plausible_from_json(axis.at("extent"), 0, kMaxAngle, "an extent")};
    if (axis.contains("share")) {
      mode.free_axis->share = plausible_from_json(axis["share"], 0, 1 + kRounding, "a share");
    }
  }
  return mode;
}

json contact_to_json(const tactile::Contact& contact) {
  return {{"finger", contact.finger},
          {"time", contact.time},
          {"p", matrix_to_json(contact.p)},
          {"n", matrix_to_json(contact.n)},
          {"f", matrix_to_json(contact.f)},
          {"point_sigma", contact.point_sigma},
          {"normal_sigma", contact.normal_sigma}};
}

tactile::Contact contact_from_json(const json& j) {
  tactile::Contact contact;
  contact.finger = static_cast<int>(
      plausible_from_json(j.at("finger"), -1, hand::kMaxFingers - 1, "the index of a finger"));
  contact.time = finite_from_json(j.at("time"));
  contact.p = vector_from_json(j.at("p"));
  contact.n = vector_from_json(j.at("n"));
  contact.f = vector_from_json(j.at("f"), kMaxForce);
  contact.point_sigma = plausible_from_json(j.at("point_sigma"), 0, kMaxLength, "point_sigma");
  contact.normal_sigma = plausible_from_json(j.at("normal_sigma"), 0, kMaxAngle, "normal_sigma");
  return contact;
}

CrediblePoseRecord pose_of(const json& j) {
  return {plausible_from_json(j.at("probability"), 0, 1 + kRounding, "a probability"),
          pose_from_json(j.at("T_world_object"))};
}

EventKind kind_from(std::string_view name) {
  for (const EventKind kind : kEventKinds) {
    if (to_string(kind) == name) return kind;
  }
  throw BadInput(fmt::format("event of unknown kind \"{}\"", name));
}

}  // namespace

std::string_view to_string(EventKind kind) {
  switch (kind) {
    case EventKind::begin:
      return "begin";
    case EventKind::note:
      return "note";
    case EventKind::end:
      return "end";
  }
  return "";
}

json to_json(const Event& event) {
  return {{"time", event.time},
          {"kind", to_string(event.kind)},
          {"phase", event.phase},
          {"text", event.text}};
}

Event event_from_json(const json& j) {
  auto phase = j.at("phase").get<std::string>();
  if (phase.find('/') != std::string::npos) {  // it is part of the names of pictures
    throw BadInput(fmt::format("'{}' is no name of a phase", phase));
  }
  return {finite_from_json(j.at("time")), kind_from(j.at("kind").get<std::string>()),
          std::move(phase), j.at("text").get<std::string>()};
}

json to_json(const EstimateRecord& estimate) {
  json modes = json::array(), contacts = json::array();
  for (const auto& mode : estimate.modes) modes.push_back(mode_to_json(mode));
  for (const auto& contact : estimate.contacts) contacts.push_back(contact_to_json(contact));
  return {{"time", estimate.time},
          {"status", estimate.status},
          {"modes", modes},
          {"contacts", contacts}};
}

EstimateRecord estimate_from_json(const json& j) {
  EstimateRecord estimate;
  estimate.time = finite_from_json(j.at("time"));
  estimate.status = j.at("status").get<std::string>();
  for (const auto& mode : j.at("modes")) estimate.modes.push_back(mode_from_json(mode));
  for (const auto& contact : j.at("contacts")) {
    estimate.contacts.push_back(contact_from_json(contact));
  }
  return estimate;
}

double entropy(const BeliefRecord& belief) {
  double rest = 1, sum = 0, least = 1;
  for (const auto& pose : belief.poses) {
    if (!(pose.probability > 0)) continue;
    sum -= pose.probability * std::log(pose.probability);
    rest -= pose.probability;
    least = std::min(least, pose.probability);
  }
  if (rest > kRounding) sum -= rest * std::log(std::min(least, rest));
  return std::max(0.0, sum);
}

json to_json(const BeliefRecord& belief) {
  json poses = json::array();
  for (const auto& pose : belief.poses) {
    poses.push_back(
        {{"probability", pose.probability}, {"T_world_object", pose_to_json(pose.T_world_object)}});
  }
  return {{"time", belief.time},
          {"source", belief.source},
          {"in_hand", belief.in_hand},
          {"poses", poses}};
}

BeliefRecord belief_from_json(const json& j) {
  BeliefRecord belief{.time = finite_from_json(j.at("time")),
                      .source = j.at("source").get<std::string>(),
                      .in_hand = j.at("in_hand").get<bool>(),
                      .poses = {}};
  for (const auto& pose : j.at("poses")) belief.poses.push_back(pose_of(pose));
  return belief;
}

}  // namespace palpate::recording
