// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/se3.hpp"
#include "tasks/relocate/exploration.hpp"
#include "tasks/relocate/relocated_object.hpp"
#include "tasks/relocate/touch_recorder.hpp"

namespace palpate::relocate {
namespace {

constexpr int kYaws = 24;  // of an object of which only the rough place is known
// Variances of an object of which only the rough place is known: rad^2, m^2, least of a place m^2.
constexpr double kTilt = 1e-4, kHeight = 1e-6, kLeast = 1e-8;
constexpr double kPushed = 0.02;   // m, by a hand that explored it and could not tell its pose
constexpr double kSameTilt = 0.1;  // rad, of a stable pose from how the object starts

/// The object with the stable pose in which one of that orientation stands, and no other.
geometry::KnownObject standing(geometry::KnownObject object,
                               const Eigen::Matrix3d& R_world_object) {
  std::optional<geometry::StablePose> found;
  double least = kSameTilt;
  for (const geometry::StablePose& stable_pose : object.stable_poses) {
    const Eigen::Matrix3d R_world_table = R_world_object * stable_pose.R_table_object.transpose();
    const double tilt = std::acos(std::clamp(R_world_table(2, 2), -1.0, 1.0));
    if (tilt >= least) continue;
    least = tilt;
    found = stable_pose;
  }
  if (!found) {
    throw BadInput(
        fmt::format("{} does not stand on its own as the task has it stand: it has no "
                    "stable pose within {} rad of that",
                    object.name, kSameTilt));
  }
  found->probability = 1;
  object.stable_poses = {*found};
  return object;
}

/// What the policy meets if the object is at that place.
PolicyInput with_place(PolicyInput input, const Eigen::Vector3d& place,
                       const RelocateStart& start) {
  auto& o = input.observation;
  const Eigen::Vector3d palm = o.segment<3>(kPalmFromTarget) + start.target;
  o.segment<3>(kPalmFromObject) = palm - place;
  o.segment<3>(kObjectFromTarget) = place - start.target;
  return input;
}

}  // namespace

void check_by_touch(const EpisodeOptions& episode) {
  for (const auto& [name, value] : {std::pair{"object_bias", episode.object_bias},
                                    {"observation_period", episode.observation_period}}) {
    if (value == 0) continue;
    throw BadInput(
        fmt::format("episode.{} = {} is of no use by touch: the policy gets the estimated position",
                    name, value));
  }
}

Relocation::Relocation(const TaskOptions& task, const RelocationOptions& options)
    : options_(options),
      shape_(make_object(task)),
      model_(make_model(task)),
      object_(standing(known_object(shape_, model_.object_mass()),
                       shape_.start_rotation.toRotationMatrix())) {}

/// What is known of an object of which only the rough place, and in which stable pose it is, are
/// known.
localization::Posterior Relocation::rough(const Eigen::Vector2d& place, RandomStream random) const {
  const auto& stable_pose = object_.object().stable_poses.front();
  const double first_yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double pushed = options_.explore ? kPushed : 0;
  const double place_variance =
      options_.uncertainty * options_.uncertainty / 3 + pushed * pushed + kLeast;
  const double yaw = std::numbers::pi / kYaws;
  Vector6d variance;
  variance << kTilt, kTilt, yaw * yaw, place_variance, place_variance, kHeight;
  localization::Posterior posterior;
  posterior.status = localization::PoseStatus::ambiguous;
  for (int i = 0; i < kYaws; ++i) {
    localization::Mode mode;
    mode.T_frame_object.translation() << place, stable_pose.height;
    mode.T_frame_object.linear() =
        Eigen::AngleAxisd(first_yaw + 2 * yaw * i, Eigen::Vector3d::UnitZ()) *
        stable_pose.R_table_object;
    mode.weight = 1.0 / kYaws;
    mode.covariance = variance.asDiagonal();
    posterior.modes.push_back(mode);
  }
  return posterior;
}

/// Where the object's centroid is, within the uncertainty.
Eigen::Vector2d Relocation::rough_place(const RelocateStart& start, RandomStream random) const {
  const Eigen::Vector3d centroid =
      shape_.start_rotation * object_.object().T_mesh_object.translation();
  Eigen::Vector2d place = start.object + centroid.head<2>();
  for (double& value : place) value -= random.uniform(-1, 1) * options_.uncertainty;
  return place;
}

TouchEpisode Relocation::run(const Policy& policy, const EpisodeOptions& episode,
                             std::uint64_t seed, std::size_t index,
                             recording::Recording* recording) const {
  check_by_touch(episode);
  const auto start = episode_start(episode, seed, index);
  const RandomStream random = RandomStream(seed, "relocation").fork("episode", index);
  const geometry::KnownObject& object = object_.object();
  RelocateTask task(model_);
  task.reset(start);
  const RelocateTouch touch(model_, options_.noise, random.fork("touch").bits());
  const std::uint64_t estimator_seed = random.fork("felt").bits();
  std::optional<TouchRecorder> recorder;
  if (recording) {
    recorder.emplace(task, object, touch.hand_model(), estimator_seed, *recording);
  }

  TouchEpisode result;
  const Eigen::Vector2d place = rough_place(start, random.fork("place"));
  localization::Posterior known;
  if (options_.explore) {
    TaskHand hand(task, model_, touch);
    auto exploration =
        explore(hand, {object_, place}, options_, estimator_seed, recorder ? &*recorder : nullptr);
    known = std::move(exploration.resting);
    result.explored = known.residual_mass() < 1;
    result.exploration = std::move(exploration.outcome);
    result.explore_steps = hand.steps();
  }
  if (!result.explored) known = rough(place, random.fork("rough"));
  const int first = options_.explore ? result.explore_steps + 1 : 0;
  if (recorder) recorder->begin(known, first * hand::kTick);
  estimation::OnlineTracker tracker(object_, touch.hand_model(), known, options_.tracking,
                                    estimator_seed);

  const auto reported_place = [&]() -> Eigen::Vector3d {
    return tracker.T_world_object() * object.T_mesh_object.inverse().translation();
  };
  const auto error = [&]() -> Eigen::Vector3d {
    return reported_place() - object_pose(task.positions()).translation();
  };
  result.resting_error = error().head<2>().norm();
  result.episode = continue_episode(task, episode.horizon, [&](int step, const PolicyInput& input) {
    const hand::HandReading reading = touch.read(task, first + step);
    tracker.update(reading);
    if (recorder) recorder->step(reading, tracker);
    result.reported_error = error().norm();
    return policy.act(with_place(input, reported_place(), start));
  });
  if (recorder) recorder->finish(start.target);
  result.estimates = tracker.estimates();
  if (tracker.estimates() > 0) result.estimate_seconds = tracker.seconds() / tracker.estimates();
  return result;
}

std::vector<TouchEpisode> Relocation::run_all(const Policy& policy, const EpisodeOptions& episode,
                                              std::uint64_t seed, std::size_t count, int threads,
                                              const ProgressCallback& progress) const {
  std::vector<TouchEpisode> episodes(count);
  parallel_ordered(
      count, threads, [&](std::size_t index) { return run(policy, episode, seed, index); },
      [&](std::size_t index, const TouchEpisode& one) {
        episodes[index] = one;
        if (progress) progress(index + 1, count);
      });
  return episodes;
}

}  // namespace palpate::relocate
