// SPDX-License-Identifier: Apache-2.0
#include "posterior_film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/options.hpp"
#include "palpate/estimation/posterior_history.hpp"
#include "palpate/evaluation/credible_poses.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/recording/touch_log.hpp"

namespace palpate::app {
namespace {

using estimation::PosteriorStep;
using estimation::TouchEvent;
using simulation::Ghost;

constexpr double kLookAbove = 0.03;  // m, above the object: the hand comes from there
constexpr std::size_t kMaxGhosts = 120;

/// What is seen of a posterior. A ghost's opacity is the root of its probability, for many share
/// it.
std::vector<Ghost> ghosts_of(const std::vector<evaluation::CrediblePose>& poses) {
  std::vector<Ghost> ghosts;
  for (const auto& pose : poses) {
    ghosts.push_back({pose.T_frame_object, std::min(1.0, std::sqrt(pose.probability))});
  }
  return ghosts;
}

evaluation::TrialOptions options_of(const recording::Recording& recording) {
  evaluation::TrialOptions options;
  parse_toml(recording.header.config_toml, "the recording", options, Earlier::accepted);
  return options;
}

std::vector<PosteriorStep> history_of(const recording::Recording& recording,
                                      const evaluation::TrialOptions& options) {
  auto log = recording::event_log(recording);
  const auto hand = skills::calibrated_hand(recording.header.hand, log, options.pick.calibrate);
  const geometry::ObjectModel object(recording.header.object);
  estimation::PoseEstimator estimator(object, options.pick_options().estimation,
                                      recording.header.seed);
  return estimation::posterior_history(estimator, hand, log);
}

std::string caption_of(const PosteriorStep& step, std::size_t touches, std::size_t poses) {
  const std::string what = step.moment.event == TouchEvent::held ? "lifted"
                           : step.moment.event == TouchEvent::closed
                               ? "grasped"
                               : fmt::format("touch {}", touches);
  const auto& modes = step.posterior.modes;
  const double best = modes.empty() ? 0 : localization::pose_probability(modes.front());
  const std::string count = fmt::format("{} credible pose{}", poses, poses == 1 ? "" : "s");
  if (best < 0.005) return fmt::format("{}\n{}", what, count);
  return fmt::format("{}\n{}, best {:.2f}", what, count, best);
}

/// What a film shows from a reading on, until the next scene.
struct Scene {
  std::size_t from = 0;  ///< reading
  bool in_hand = false;  ///< the poses go with the hand
  std::vector<Ghost> ghosts;
  std::string caption;
};

std::vector<Scene> scenes_of(const std::vector<PosteriorStep>& history, std::vector<Ghost> prior) {
  std::vector<Scene> scenes{
      {0, false, std::move(prior), "before the first touch\nany stable pose, any yaw"}};
  std::size_t touches = 0;
  for (const PosteriorStep& step : history) {
    const bool in_hand =
        step.moment.event == TouchEvent::closed || step.moment.event == TouchEvent::held;
    touches += in_hand ? 0 : 1;
    auto ghosts = ghosts_of(evaluation::credible_poses(step.posterior, kMaxGhosts));
    std::string caption = caption_of(step, touches, ghosts.size());
    if (ghosts.empty() && !in_hand) {  // as before
      ghosts = scenes.back().ghosts;
      caption = fmt::format("touch {}\nno estimate yet", touches);
    }
    scenes.push_back({step.moment.reading, in_hand, std::move(ghosts), std::move(caption)});
  }
  return scenes;
}

simulation::DrawnState state_at(const recording::Recording& recording, std::size_t reading,
                                const Scene& scene) {
  const recording::Frame& frame = recording.frames[reading];
  simulation::DrawnState state{frame.truth->T_world_object,
                               frame.truth->joints,
                               frame.reading.mount,
                               0,
                               scene.ghosts,
                               scene.caption};
  if (!scene.in_hand) return state;
  const Eigen::Isometry3d moved =
      frame.reading.mount.pose() * recording.frames[scene.from].reading.mount.pose().inverse();
  for (Ghost& ghost : state.ghosts) ghost.T_world_object = moved * ghost.T_world_object;
  return state;
}

}  // namespace

std::vector<simulation::Image> film_posterior(const recording::Recording& recording,
                                              simulation::Renderer& renderer,
                                              const FilmOptions& options) {
  auto log = recording::event_log(recording);
  const auto starts = log.all(TouchEvent::guarded_move);
  const auto trial = options_of(recording);
  const auto history = history_of(recording, trial);
  if (starts.empty() || history.empty()) throw BadInput("the recording has no touch of the object");
  auto prior = evaluation::prior_poses(recording.header.object, trial.pick_options().estimation,
                                       log.T_world_table);
  for (auto& pose : prior)
    pose.probability = 1.0 / static_cast<double>(prior.size());  // to be seen
  const auto scenes = scenes_of(history, ghosts_of(prior));
  simulation::Camera camera = options.camera;
  camera.lookat = recording.frames[starts.front()].truth->T_world_object.translation();
  camera.lookat.z() += kLookAbove;
  const double tick = recording.frames[1].reading.time - recording.frames[0].reading.time;
  const auto stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(options.speed * options.picture_time / tick)));
  std::vector<simulation::Image> images;
  std::size_t scene = 0;
  for (std::size_t i = starts.front(); i <= history.back().moment.reading + stride; i += stride) {
    const std::size_t reading = std::min(i, recording.frames.size() - 1);
    while (scene + 1 < scenes.size() && scenes[scene + 1].from <= reading) ++scene;
    images.push_back(renderer.render(state_at(recording, reading, scenes[scene]), camera));
  }
  const auto still =
      static_cast<std::size_t>(std::lround(options.last_time / options.picture_time));
  images.resize(images.size() + still, images.back());
  return images;
}

}  // namespace palpate::app
