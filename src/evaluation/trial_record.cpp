// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/trial_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <type_traits>

#include "palpate/core/error.hpp"
#include "palpate/skills/place/place.hpp"

namespace palpate::evaluation {
namespace {

using nlohmann::json;

// Records hold the numbers of these values: none may move, and a new one comes after the others.
template <class Enum>
constexpr bool counts_up(std::initializer_list<Enum> values) {
  int number = 0;
  return std::ranges::all_of(values,
                             [&](Enum value) { return static_cast<int>(value) == number++; });
}
using localization::PoseStatus, skills::PhaseStatus, skills::PlaceStatus, skills::Fault;
static_assert(counts_up({PoseStatus::certain, PoseStatus::ambiguous, PoseStatus::no_pose}));
static_assert(counts_up({PhaseStatus::ok, PhaseStatus::failed, PhaseStatus::timed_out,
                         PhaseStatus::fault}));
static_assert(counts_up({PlaceStatus::placed, PlaceStatus::ambiguous, PlaceStatus::unreachable,
                         PlaceStatus::refused, PlaceStatus::slipped, PlaceStatus::lost,
                         PlaceStatus::stuck, PlaceStatus::missing, PlaceStatus::under_way,
                         PlaceStatus::stopped}));
static_assert(counts_up({Fault::none, Fault::stop_requested, Fault::not_finite, Fault::out_of_range,
                         Fault::implausible_change, Fault::frozen, Fault::late, Fault::silent,
                         Fault::excess_force, Fault::unsensed_load, Fault::joint_stuck,
                         Fault::touch_lost, Fault::invalid_command, Fault::log_full,
                         Fault::exception, Fault::not_at_start, Fault::touch_swapped}));
template <class T>
constexpr bool kNumbered = std::is_same_v<T, PoseStatus> || std::is_same_v<T, PhaseStatus> ||
                           std::is_same_v<T, PlaceStatus> || std::is_same_v<T, Fault>;

/// Writes members under their names.
class ToJson {
 public:
  explicit ToJson(json& target) : target_(target) {}

  template <class T>
  void operator()(const char* name, T& value) const {
    if constexpr (std::is_enum_v<T>) {
      static_assert(kNumbered<T>);
      target_[name] = static_cast<int>(value);
    } else {
      target_[name] = value;  // JSON has no nan: null
    }
  }

  template <class T, class Visit>
  void part(const char* name, T& value, const Visit& visit) const {
    json part = json::object();
    visit(value, ToJson(part));
    target_[name] = std::move(part);
  }

 private:
  json& target_;
};

/// Reads members by their names.
class FromJson {
 public:
  explicit FromJson(const json& source) : source_(source) {}

  template <class T>
  void operator()(const char* name, T& value) const {
    const json& found = source_.at(name);
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(found.get<int>());
    } else if constexpr (std::is_same_v<T, double>) {
      value = found.is_null() ? std::numeric_limits<double>::quiet_NaN() : found.get<double>();
    } else {
      found.get_to(value);
    }
  }

  template <class T, class Visit>
  void part(const char* name, T& value, const Visit& visit) const {
    visit(value, FromJson(source_.at(name)));
  }

 private:
  const json& source_;
};

constexpr auto kError = [](localization::PoseError& error, const auto& v) {
  v("rotation", error.rotation);
  v("translation", error.translation);
};

constexpr auto kPhase = [](skills::PhaseReport& phase, const auto& v) {
  v("name", phase.name);
  v("status", phase.status);
  v("robot_seconds", phase.robot_seconds);
  v("wall_seconds", phase.wall_seconds);
};

constexpr auto kFault = [](skills::FaultReport& report, const auto& v) {
  v("fault", report.fault);
  v("detail", report.detail);
  v("time", report.time);
};

constexpr auto kPick = [](skills::PickResult& result, const auto& v) {
  v("held", result.held);
  v("attempts", result.attempts);
  v("regrasps", result.regrasps);
  v("failed_phase", result.failed_phase);
  v("limited_commands", result.limited_commands);
  v.part("fault", result.fault, kFault);
};

constexpr auto kMetrics = [](TrialMetrics& metrics, const auto& v) {
  v("lifted", metrics.lifted);
  v("slip", metrics.slip);
  v("has_pose", metrics.has_pose);
  v("object_ok", metrics.object_ok);
  v("object_probability", metrics.object_probability);
  v("other_probability", metrics.other_probability);
  v("pose_ok", metrics.pose_ok);
  v("pose_tight", metrics.pose_tight);
  v("covered", metrics.covered);
  v("status", metrics.status);
  v("probability", metrics.probability);
  v("free_extent", metrics.free_extent);
  v("pose_ok_before_lift", metrics.pose_ok_before_lift);
  v("pose_ok_before_probe", metrics.pose_ok_before_probe);
  v("pose_ok_tracked", metrics.pose_ok_tracked);
  v("tracked_share", metrics.tracked_share);
  v("probes", metrics.probes);
  v("explored_motion", metrics.explored_motion);
  v("tip_force", metrics.tip_force);
  v("peak_load", metrics.peak_load);
  v("peak_tip_force", metrics.peak_tip_force);
  v.part("error", metrics.error, kError);
};

constexpr auto kPlaceMetrics = [](PlaceMetrics& metrics, const auto& v) {
  v("placed", metrics.placed);
  v("tight", metrics.tight);
  v("wrong", metrics.wrong);
  v("dropped", metrics.dropped);
  v("in_stable_pose", metrics.in_stable_pose);
  v.part("error", metrics.error, kError);
  v.part("estimate", metrics.estimate, kError);
  v.part("release", metrics.release, kError);
};

constexpr auto kPlace = [](skills::PlaceResult& place, const auto& v) {
  v("status", place.status);
  v("certain", place.certain);
  v("on_the_way", place.on_the_way);
};

constexpr auto kTrial = [](Trial& trial, const auto& v) {
  v("stable_pose", trial.start.stable_pose);
  v("robot_seconds", trial.robot_seconds);
  v.part("pick", trial.result, kPick);
  v.part("metrics", trial.metrics, kMetrics);
  v.part("place_metrics", trial.place_metrics, kPlaceMetrics);
};

json phases_to_json(const std::vector<skills::PhaseReport>& phases) {
  json all = json::array();
  for (skills::PhaseReport phase : phases) {
    json one;
    kPhase(phase, ToJson(one));
    all.push_back(std::move(one));
  }
  return all;
}

std::vector<skills::PhaseReport> phases_from_json(const json& all) {
  std::vector<skills::PhaseReport> phases;
  for (const json& one : all) kPhase(phases.emplace_back(), FromJson(one));
  return phases;
}

json weights_to_json(const std::vector<localization::Mode>& modes) {
  json weights = json::array();
  for (const auto& mode : modes) weights.push_back(mode.weight);
  return weights;
}

json place_to_json(skills::PlaceResult place) {
  json result;
  kPlace(place, ToJson(result));
  result["phases"] = phases_to_json(place.phases);
  result["let_go"] = place.T_world_placed.has_value();
  return result;
}

skills::PlaceResult place_from_json(const json& source) {
  skills::PlaceResult place;
  kPlace(place, FromJson(source));
  place.phases = phases_from_json(source.at("phases"));
  if (source.at("let_go").get<bool>()) place.T_world_placed = Eigen::Isometry3d::Identity();
  return place;
}

}  // namespace

json trial_to_json(const Trial& trial) {
  json result;
  Trial copy = trial;
  kTrial(copy, ToJson(result));
  result["phases"] = phases_to_json(trial.result.phases);
  result["weights"] = weights_to_json(trial.result.estimate.posterior.modes);
  result["place"] = trial.place ? place_to_json(*trial.place) : json();
  return result;
}

Trial trial_from_json(const json& source) {
  Trial trial;
  kTrial(trial, FromJson(source));
  trial.result.phases = phases_from_json(source.at("phases"));
  for (const json& weight : source.at("weights")) {
    trial.result.estimate.posterior.modes.emplace_back().weight = weight.get<double>();
  }
  if (!source.at("place").is_null()) trial.place = place_from_json(source.at("place"));
  if (trial.metrics.has_pose && trial.result.estimate.posterior.modes.empty()) {
    throw BadInput("a trial with a pose and without modes");
  }
  return trial;
}

}  // namespace palpate::evaluation
