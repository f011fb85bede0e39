// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/evaluation/trial.hpp"
#include "tasks/relocate/relocated_object.hpp"
#include "tasks/relocate/touch_recorder.hpp"

namespace palpate::relocate {
namespace {

constexpr int kYaws = 24;  // of an object of which only the rough place is known
// Variances of an object of which only the rough place is known: rad^2, m^2, least of a place m^2.
constexpr double kTilt = 1e-4, kHeight = 1e-6, kLeast = 1e-8;
constexpr double kSameTilt = 0.1;  // rad, of a stable pose from how the object starts

/// How an object of that orientation stands: in which stable pose, by which yaw.
simulation::Start standing(const geometry::KnownObject& object,
                           const Eigen::Matrix3d& R_world_object) {
  simulation::Start start{-1, 0, Eigen::Vector2d::Zero()};
  double least = kSameTilt;
  for (std::size_t i = 0; i < object.stable_poses.size(); ++i) {
    const Eigen::Matrix3d R_world_table =
        R_world_object * object.stable_poses[i].R_table_object.transpose();
    const double tilt = std::acos(std::clamp(R_world_table(2, 2), -1.0, 1.0));
    if (tilt >= least) continue;
    least = tilt;
    start.stable_pose = static_cast<int>(i);
    start.yaw = std::atan2(R_world_table(1, 0), R_world_table(0, 0));
  }
  if (start.stable_pose < 0) {
    throw BadInput(
        fmt::format("{} does not stand on its own as the task has it stand: it has no "
                    "stable pose within {} rad of that",
                    object.name, kSameTilt));
  }
  return start;
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
      object_(known_object(shape_, model_.object_mass())),
      standing_(standing(object_.object(), shape_.start_rotation.toRotationMatrix())) {}

/// The estimate by touch of the object that a world puts there; no pose if there is none.
localization::Posterior Relocation::explored(const Eigen::Vector2d& place,
                                             std::uint64_t seed) const {
  simulation::WorldOptions world_options;
  world_options.noise = options_.noise;
  simulation::World world(object_.object(), world_options, seed);
  world.reset({standing_.stable_pose, standing_.yaw, place},
              evaluation::waiting_command(world.hand_model()));
  skills::Executor robot(world.hand(), world.hand_model(),
                         evaluation::waiting_command(world.hand_model()));
  skills::PickState state;
  try {
    skills::HeightProbePhase height_probe(
        options_.height_probe,
        geometry::top_of(object_.object(), object_.object().stable_poses[standing_.stable_pose]));
    estimation::PoseEstimator estimator(object_, options_.resting, seed);
    skills::ExplorePhase explore(estimator, options_.exploring);
    if (skills::run_phase(height_probe, robot, state).status == skills::PhaseStatus::ok)
      skills::run_phase(explore, robot, state);
  } catch (const std::exception&) {
    if (!world.diverged()) throw;
  }
  if (world.diverged() || !state.resting) return {};
  return *state.resting;
}

/// What is known at the origin of an object of which only the rough place, and on which side it
/// stands, are known.
localization::Posterior Relocation::rough(RandomStream random) const {
  const auto& stable_pose =
      object_.object().stable_poses[static_cast<std::size_t>(standing_.stable_pose)];
  const double first_yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double place = options_.uncertainty * options_.uncertainty / 3;
  const double yaw = std::numbers::pi / kYaws;
  Vector6d variance;
  variance << kTilt, kTilt, yaw * yaw, place + kLeast, place + kLeast, kHeight;
  localization::Posterior posterior;
  posterior.status = localization::PoseStatus::ambiguous;
  for (int i = 0; i < kYaws; ++i) {
    localization::Mode mode;
    mode.T_frame_object.translation().z() = stable_pose.height;
    mode.T_frame_object.linear() =
        Eigen::AngleAxisd(first_yaw + 2 * yaw * i, Eigen::Vector3d::UnitZ()) *
        stable_pose.R_table_object;
    mode.weight = 1.0 / kYaws;
    mode.covariance = variance.asDiagonal();
    posterior.modes.push_back(mode);
  }
  return posterior;
}

/// What is known of the object when the policy starts, in the task, and whether it was explored.
std::pair<localization::Posterior, bool> Relocation::resting(const RelocateStart& start,
                                                             const RandomStream& random) const {
  RandomStream chance = random.fork("place");
  Eigen::Vector2d from_rough;
  for (double& value : from_rough) value = chance.uniform(-1, 1) * options_.uncertainty;
  localization::Posterior known;
  if (options_.explore) known = explored(from_rough, random.fork("explore").bits());
  const bool is_explored = known.residual_mass() < 1;
  if (!is_explored) known = rough(random.fork("rough"));

  const Eigen::Vector3d centroid =
      shape_.start_rotation * object_.object().T_mesh_object.translation();
  const Eigen::Vector2d rough_place = start.object + centroid.head<2>() - from_rough;
  estimation::transform(
      Eigen::Isometry3d(Eigen::Translation3d(rough_place.x(), rough_place.y(), 0)), known);
  return {known, is_explored};
}

TouchEpisode Relocation::run(const Policy& policy, const EpisodeOptions& episode,
                             std::uint64_t seed, std::size_t index,
                             recording::Recording* recording) const {
  check_by_touch(episode);
  const auto start = episode_start(episode, seed, index);
  const RandomStream random = RandomStream(seed, "relocation").fork("episode", index);
  TouchEpisode result;
  localization::Posterior known;
  std::tie(known, result.explored) = resting(start, random);

  RelocateTask task(model_);
  task.reset(start);
  RelocateTouch touch(model_, options_.noise, random.fork("touch").bits());
  const std::uint64_t tracker_seed = random.fork("felt").bits();
  const geometry::KnownObject& object = object_.object();
  estimation::OnlineTracker tracker(object_, touch.hand_model(), known, options_.tracking,
                                    tracker_seed);
  std::optional<TouchRecorder> recorder;
  if (recording) recorder.emplace(*recording, object, touch.hand_model(), tracker_seed, known);

  const auto reported_place = [&]() -> Eigen::Vector3d {
    return tracker.T_world_object() * object.T_mesh_object.inverse().translation();
  };
  const auto error = [&]() -> Eigen::Vector3d {
    return reported_place() - object_pose(task.positions()).translation();
  };
  result.resting_error = error().head<2>().norm();
  result.episode =
      run_episode(task, start, episode.horizon, [&](int step, const PolicyInput& input) {
        const hand::HandReading reading = touch.read(task, step);
        tracker.update(reading);
        if (recorder) recorder->step(reading, task, tracker);
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
