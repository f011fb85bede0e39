// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/angle.hpp"
#include "palpate/recording/touch_log.hpp"
#include "recording/matrix_json.hpp"
#include "recording/note_numbers.hpp"
#include "recording/page_data.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

/// Phases in order; one that never ended lasts to the last frame.
json phases_to_json(const std::vector<Event>& events, double last, double origin) {
  json phases = json::array();
  for (const Event& event : events) {
    if (event.kind == EventKind::begin) {
      phases.push_back({{"name", event.phase},
                        {"begin", event.time - origin},
                        {"end", std::max(last, event.time) - origin},
                        {"outcome", ""}});
    }
    if (event.kind != EventKind::end || phases.empty()) continue;
    if (phases.back()["name"] != event.phase) continue;
    phases.back()["end"] = event.time - origin;
    phases.back()["outcome"] = event.text;
  }
  return phases;
}

constexpr std::string_view kFixture = "fixture ", kPath = "path ", kCredible = "credible";
constexpr std::size_t kBoxNumbers = kPoseNumbers + 3;

/// Where the object was to be put, the way planned there (x y z of its centroid), the boxes of the
/// fixture (pose, then half extents), and when the hand let go there, as the notes state.
json placement_to_json(const std::vector<Event>& events, double origin) {
  json placement = {{"target", nullptr},
                    {"path", json::array()},
                    {"fixture", json::array()},
                    {"let_go", json::array()}};
  const std::string let_go = touch_note(estimation::TouchEvent::placed);
  for (const Event& event : events) {
    if (event.kind != EventKind::note) continue;
    const auto target = numbers_after(kTargetNote, event.text, kPoseNumbers);
    if (!target.empty()) placement["target"] = target;
    const auto path = numbers_after(kPath, event.text);
    if (path.size() % 3 == 0 && !path.empty()) placement["path"] = path;
    const auto box = numbers_after(kFixture, event.text, kBoxNumbers);
    if (!box.empty()) placement["fixture"].push_back(box);
    if (event.text == let_go) placement["let_go"].push_back(event.time - origin);
  }
  return placement;
}

/// The truth in the last frame up to that time, if any.
const FrameTruth* truth_at(const std::vector<Frame>& frames, double time) {
  const auto after =
      std::upper_bound(frames.begin(), frames.end(), time + hand::kTick / 2,
                       [](double t, const Frame& frame) { return t < frame.reading.time; });
  if (after == frames.begin()) return nullptr;
  const auto& truth = std::prev(after)->truth;
  return truth ? &*truth : nullptr;
}

/// Rotation (rad) between the poses, modulo the symmetries of the object.
double rotation_error(const Eigen::Isometry3d& estimate, const Eigen::Isometry3d& truth,
                      const std::vector<Eigen::Matrix3d>& symmetries) {
  double least = rotation_distance(estimate.linear(), truth.linear());
  for (const auto& S : symmetries) {
    least = std::min(least, rotation_distance(estimate.linear() * S, truth.linear()));
  }
  return least;
}

/// Poses of a mode: one, or steps of one degree along its free axis.
std::vector<Eigen::Isometry3d> poses_of(const PoseModeRecord& mode) {
  if (!mode.free_axis) return {mode.T_world_object};
  std::vector<Eigen::Isometry3d> poses;
  const FreeAxisRecord& axis = *mode.free_axis;
  const int steps = static_cast<int>(std::min(axis.extent, std::numbers::pi) / kDegree);
  for (int k = -steps; k <= steps; ++k) {
    poses.push_back(Eigen::Translation3d(axis.point) *
                    Eigen::AngleAxisd(k * kDegree, axis.direction) *
                    Eigen::Translation3d(-axis.point) * mode.T_world_object);
  }
  return poses;
}

void add_errors(const PoseModeRecord& mode, const Eigen::Isometry3d& truth,
                const std::vector<Eigen::Matrix3d>& symmetries, json& j) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& pose : poses_of(mode)) {
    const double error = rotation_error(pose, truth, symmetries);
    if (error >= least) continue;
    least = error;
    j["rotation_error_deg"] = error / kDegree;
    j["translation_error_mm"] = 1000 * (pose.translation() - truth.translation()).norm();
  }
}

json mode_with_sigmas(const PoseModeRecord& mode) {
  const auto sigma = [&](int block) {
    return std::sqrt(std::max(0.0, mode.covariance.diagonal().segment<3>(block).mean()));
  };
  json j = {{"T_world_object", pose_to_json(mode.T_world_object)},
            {"weight", mode.weight},
            {"rotation_sigma_deg", sigma(0) / kDegree},
            {"translation_sigma_mm", 1000 * sigma(3)}};
  if (mode.free_axis) {
    j["free_axis"] = {{"point", matrix_to_json(mode.free_axis->point)},
                      {"direction", matrix_to_json(mode.free_axis->direction)},
                      {"extent_deg", mode.free_axis->extent / kDegree}};
  }
  return j;
}

}  // namespace

json estimate_to_json(const EstimateRecord& estimate, const PageContext& context) {
  json modes = json::array(), contacts = json::array();
  for (const auto& mode : estimate.modes) {
    modes.push_back(mode_with_sigmas(mode));
    if (!context.truth) continue;
    add_errors(mode, context.truth->T_world_object, context.symmetries, modes.back());
  }
  for (const auto& contact : estimate.contacts) {
    contacts.push_back({{"finger", contact.finger},
                        {"p", matrix_to_json(contact.p)},
                        {"n", matrix_to_json(contact.n)}});
  }
  return {{"time", estimate.time - context.origin},
          {"status", estimate.status},
          {"modes", modes},
          {"contacts", contacts}};
}

json belief_to_json(const BeliefRecord& belief, const PageContext& context) {
  json poses = json::array();
  for (const auto& pose : belief.poses) {
    poses.push_back(
        {{"probability", pose.probability}, {"T_world_object", pose_to_json(pose.T_world_object)}});
  }
  json j = {{"time", belief.time - context.origin},
            {"source", belief.source},
            {"in_hand", belief.in_hand},
            {"entropy", entropy(belief)},
            {"poses", poses}};
  if (context.truth && !belief.poses.empty()) {
    PoseModeRecord best;
    best.T_world_object = belief.poses.front().T_world_object;
    add_errors(best, context.truth->T_world_object, context.symmetries, j);
  }
  return j;
}

json events_to_json(const std::vector<Event>& events, double last, double origin) {
  return {{"phases", phases_to_json(events, last, origin)},
          {"placement", placement_to_json(events, origin)}};
}

bool holds_belief(const Event& event) {
  return event.kind == EventKind::note && event.text.starts_with(kCredible);
}

BeliefRecord belief_of(const Event& event) {
  constexpr std::size_t kStride = 1 + kPoseNumbers;
  BeliefRecord belief{.time = event.time, .source = "touch", .in_hand = false, .poses = {}};
  const auto values = numbers_after(kCredible, event.text);
  for (std::size_t i = 0; i + kStride <= values.size(); i += kStride) {
    // Rounded in the text, so that it is no rotation to the last digit.
    Eigen::Matrix4d T =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(&values[i + 1]);
    belief.poses.push_back({values[i], Eigen::Isometry3d(T)});
  }
  return belief;
}

json page_story(const Recording& recording) {
  const double origin = page_origin(recording);
  const auto context_at = [&](double time) {
    return PageContext{origin, truth_at(recording.frames, time),
                       recording.header.object.symmetries};
  };
  std::vector<BeliefRecord> beliefs = recording.beliefs;
  if (beliefs.empty()) {  // of before they were recorded
    for (const Event& event : recording.events) {
      if (holds_belief(event)) beliefs.push_back(belief_of(event));
    }
  }
  std::ranges::stable_sort(beliefs, {}, &BeliefRecord::time);
  json estimates = json::array(), shown = json::array();
  for (const auto& estimate : recording.estimates) {
    estimates.push_back(estimate_to_json(estimate, context_at(estimate.time)));
  }
  for (const auto& belief : beliefs) {
    shown.push_back(belief_to_json(belief, context_at(belief.time)));
  }
  const double last = recording.frames.empty() ? 0 : recording.frames.back().reading.time;
  json story = events_to_json(recording.events, last, origin);
  story.update({{"beliefs", shown}, {"estimates", estimates}});
  return story;
}

}  // namespace palpate::recording
