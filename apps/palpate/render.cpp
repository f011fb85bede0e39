// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "common.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "object_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/version.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/recording/target.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/rendering/renderer.hpp"
#include "palpate/tasks/relocate/episode_recording.hpp"
#include "posterior_film.hpp"
#include "replay_file.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr double kPictureTime = 0.1;    // s of a video
constexpr double kMostPictures = 3000;  // of a video
constexpr double kVideoDistance = 1.3;  // times that of a picture: the hand moves, the camera not

struct RenderArguments {
  CommonOptions common;
  std::string object = "mug";
  std::string hand, arm;
  std::string recording;
  std::string size = "1200x800";
  bool video = false, posterior = false, gif = false;
  double speed = 8;
  simulation::Camera camera;
};

struct Picture {
  std::string phase;
  double time = 0;  ///< s
  fs::path file;
};

/// Width and height of a text like 1200x800; none if it is not like that.
std::optional<std::pair<int, int>> parse_size(const std::string& text) {
  int width = 0, height = 0, end = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &end) != 2 ||
      static_cast<std::size_t>(end) != text.size()) {
    return std::nullopt;
  }
  return std::pair(width, height);
}

/// What is wrong with the text of a size, for the command line; nothing if it is one.
std::string size_error(const std::string& text) {
  return parse_size(text) ? "" : fmt::format("{} is not WIDTHxHEIGHT in pixels", text);
}

fs::path output_folder(const RenderArguments& arguments) {
  if (!arguments.common.out.empty()) return arguments.common.out;
  if (!arguments.recording.empty()) {
    const fs::path folder = fs::path(arguments.recording).parent_path();
    return folder.empty() ? "." : folder;
  }
  return fs::path("out") /
         fmt::format("render-{}-{}", short_name(arguments.object), arguments.common.seed);
}

/// Picks the object up and records it. Whether that succeeds does not matter to a picture.
fs::path record_pick(const RenderArguments& arguments, const fs::path& folder) {
  const CommonOptions& common = arguments.common;
  const auto options = resolve_trial(common, arguments.hand, arguments.arm);
  const bool sensor_reported_errors = options.touch.from_biotacs();  // bad ones are named first
  const geometry::ObjectModel object(geometry::load_known_object(arguments.object));
  const simulation::World world(object.object(), options.world, common.seed);
  const OutputFolder output(folder, {"recording.h5"}, common.force);
  const Notice notice(fmt::format("picking up {}", arguments.object), common.quiet);
  const fs::path path = folder / "recording.h5";
  recording::Writer writer(
      path, {std::string(version()), common.seed, object.object(), world.hand_model(),
             config_header(common) + to_toml(options), sensor_reported_errors});
  evaluation::run_trial(object, options, common.seed, &writer);
  writer.finish();
  return path;
}

/// The last frame that is not later than the time.
const recording::Frame& frame_at(const recording::Recording& recording, double time) {
  const auto later = std::upper_bound(
      recording.frames.begin() + 1, recording.frames.end(), time,
      [](double t, const recording::Frame& frame) { return t < frame.reading.time; });
  return *(later - 1);
}

/// What a frame looks like: with the object see-through at its target, where there is one.
simulation::DrawnState state_of(const recording::Recording& recording,
                                const recording::Frame& frame) {
  constexpr double kTargetOpacity = 0.35;
  simulation::DrawnState state{frame.truth->T_world_object, frame.truth->joints,
                               frame.reading.mount};
  const auto target = recording::target_at(recording.events, frame.reading.time);
  if (target) state.ghosts.push_back({*target, kTargetOpacity});
  return state;
}

simulation::Image draw(simulation::Renderer& renderer, const recording::Recording& recording,
                       const recording::Frame& frame, simulation::Camera camera) {
  const Eigen::Isometry3d& T_world_object = frame.truth->T_world_object;
  camera.lookat =
      0.6 * T_world_object.translation() + 0.4 * frame.reading.mount.pose().translation();
  return renderer.render(state_of(recording, frame), camera);
}

hand::Description drawn_hand(const recording::Recording& recording) {
  try {
    return load_recorded_hand(recording.header.hand);
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}; palpate view draws its recorded spheres", error.what()));
  }
}

simulation::Renderer renderer_of(const recording::Recording& recording,
                                 const RenderArguments& arguments) {
  const auto [width, height] = *parse_size(arguments.size);
  return {drawn_hand(recording), recording.header.object, width, height};
}

std::string phase_file(std::size_t number, const std::string& phase) {
  return fmt::format("{}-{}.png", number, phase);
}

/// A file of moving pictures.
std::string animation_file(std::string_view name, const RenderArguments& arguments) {
  return fmt::format("{}.{}", name, arguments.gif ? "gif" : "png");
}

/// The names of all that is drawn.
std::vector<std::string> picture_files(const recording::Recording& recording,
                                       const RenderArguments& arguments) {
  std::vector<std::string> names;
  for (const recording::Event& event : recording.events) {
    if (event.kind != recording::EventKind::end) continue;
    names.push_back(phase_file(names.size() + 1, event.phase));
  }
  if (arguments.video) names.push_back(animation_file("video", arguments));
  if (arguments.posterior) names.push_back(animation_file("posterior", arguments));
  return names;
}

/// One picture at the end of every phase.
std::vector<Picture> draw_phases(const recording::Recording& recording, const fs::path& folder,
                                 const RenderArguments& arguments) {
  simulation::Renderer renderer = renderer_of(recording, arguments);
  std::vector<Picture> pictures;
  for (const recording::Event& event : recording.events) {
    if (event.kind != recording::EventKind::end) continue;
    Picture picture{event.phase, event.time, folder / phase_file(pictures.size() + 1, event.phase)};
    simulation::save_png(
        picture.file, draw(renderer, recording, frame_at(recording, event.time), arguments.camera));
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

/// The whole pick from one place, faster than it was.
Picture draw_video(const recording::Recording& recording, const fs::path& folder,
                   const RenderArguments& arguments) {
  simulation::Renderer renderer = renderer_of(recording, arguments);
  simulation::Camera camera = arguments.camera;
  camera.distance *= kVideoDistance;
  const double end = recording.frames.back().reading.time;
  std::vector<simulation::Image> images;
  for (double time = recording.frames.front().reading.time; time < end;
       time += arguments.speed * kPictureTime) {
    images.push_back(renderer.render(state_of(recording, frame_at(recording, time)), camera));
  }
  Picture video{"video", end, folder / animation_file("video", arguments)};
  simulation::save_animation(video.file, images, kPictureTime);
  return video;
}

/// The poses that the touches leave credible, as ghosts.
Picture draw_posterior(const recording::Recording& recording, const fs::path& folder,
                       const RenderArguments& arguments) {
  simulation::Renderer renderer = renderer_of(recording, arguments);
  FilmOptions options;
  options.speed = arguments.speed;
  options.picture_time = kPictureTime;
  options.camera = arguments.camera;
  const auto images = film_posterior(recording, renderer, options);
  Picture film{"posterior", recording.frames.back().reading.time,
               folder / animation_file("posterior", arguments)};
  simulation::save_animation(film.file, images, kPictureTime);
  return film;
}

/// An episode by touch is of the Adroit hand, whose mount is another frame: the Shadow hand is
/// drawn with its palm where the recorded one is.
void place_by_palm(recording::Recording& recording) {
  const hand::Description& recorded = recording.header.hand;
  const hand::Description drawn = simulation::load_hand(recorded.name);
  const auto palm_in_mount = [](const hand::Description& hand, const hand::JointVector& joints) {
    return hand::forward_kinematics(hand, joints)[static_cast<std::size_t>(hand.palm)];
  };
  for (recording::Frame& frame : recording.frames) {
    const hand::JointVector& joints = frame.truth->joints;
    frame.reading.mount =
        hand::MountPosition::at(frame.reading.mount.pose() * palm_in_mount(recorded, joints) *
                                palm_in_mount(drawn, joints).inverse());
  }
}

recording::Recording read_drawable(const fs::path& path) {
  auto recording = recording::read_recording(path);
  const bool drawable =
      !recording.frames.empty() &&
      std::all_of(recording.frames.begin(), recording.frames.end(),
                  [](const recording::Frame& frame) { return frame.truth.has_value(); });
  if (!drawable) {
    throw BadInput(fmt::format("{} does not state where the object was", path.string()));
  }
  if (relocate::is_episode(recording)) place_by_palm(recording);
  return recording;
}

/// @throws BadInput for a recording that is too long to be shown at that speed
void check_video(const recording::Recording& recording, double speed) {
  const double seconds =
      recording.frames.back().reading.time - recording.frames.front().reading.time;
  const double pictures = seconds / (speed * kPictureTime);
  if (pictures <= kMostPictures) return;
  throw BadInput(fmt::format(
      "{:.0f} s at --speed {} are a video of {:.0f} pictures, more than {}: raise --speed", seconds,
      speed, pictures, kMostPictures));
}

int render(const RenderArguments& arguments) {
  const fs::path folder = output_folder(arguments);
  const fs::path given = arguments.recording;
  const auto recording = read_drawable(given.empty() ? record_pick(arguments, folder) : given);
  if (arguments.posterior && relocate::is_episode(recording)) {
    throw BadInput(fmt::format(
        "--posterior draws the poses of a pick, and {} is an episode of the relocate task: palpate "
        "view shows its estimates",
        given.string()));
  }
  if (arguments.video || arguments.posterior) check_video(recording, arguments.speed);
  make_writable_folder(folder);
  // Beside their recording pictures are drawn again and again.
  const auto output =
      given.empty() ? nullptr : claim_output(arguments.common, picture_files(recording, arguments));
  std::optional<Notice> notice(std::in_place, "drawing", arguments.common.quiet);
  auto pictures = draw_phases(recording, folder, arguments);
  if (arguments.video) pictures.push_back(draw_video(recording, folder, arguments));
  if (arguments.posterior) pictures.push_back(draw_posterior(recording, folder, arguments));
  notice.reset();
  auto files = nlohmann::json::array();
  for (const Picture& picture : pictures) {
    files.push_back(
        {{"phase", picture.phase}, {"time", picture.time}, {"file", picture.file.string()}});
    if (arguments.common.json) continue;
    fmt::print("{:<12} {:7.2f} s  {}\n", picture.phase, picture.time, picture.file.string());
  }
  if (arguments.common.json) print_json(nlohmann::json{{"files", files}});
  if (pictures.empty()) return kDone;
  print_next(arguments.common,
             fmt::format("open {} in a browser", quoted(pictures.back().file.string())));
  return kDone;
}

/// @throws CLI::Error for options that would have no effect
void check_use(const CLI::App& command) {
  const auto given = [&command](const char* option) { return command.count(option) > 0; };
  for (const char* const of_pick : {"--config", "--set", "--seed"}) {
    if (given("recording") && given(of_pick)) throw CLI::ExcludesError("RECORDING", of_pick);
  }
  if (given("recording") && given("--force") && !given("--out")) {
    throw CLI::RequiresError("--force of a RECORDING", "--out");
  }
  if (given("--video") || given("--posterior")) return;
  for (const char* const of_animation : {"--gif", "--speed"}) {
    if (given(of_animation)) throw CLI::RequiresError(of_animation, "--video or --posterior");
  }
}

}  // namespace

void add_render(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<RenderArguments>();
  auto& command =
      *program.add_subcommand("render", "Render a pick: one PNG image at the end of each phase");
  auto* const recording =
      command.add_option("recording", arguments->recording,
                         "recording.h5 of a pick, or its folder; without it, an object is picked "
                         "up first");
  accept_folder_of_pick(*recording);
  command
      .add_option("--object", arguments->object,
                  "mug, bottle, box, bracket, duck, or a mesh file in metres")
      ->type_name("O")
      ->capture_default_str()
      ->excludes(recording);
  add_hand_option(command, arguments->hand).excludes(recording);
  add_arm_option(command, arguments->arm).excludes(recording);
  command.add_option("--size", arguments->size, "size of a picture, pixels")
      ->option_text("WxH")
      ->check(size_error)
      ->capture_default_str();
  command
      .add_option("--azimuth", arguments->camera.azimuth_deg,
                  "azimuth of the view direction about z, deg")
      ->capture_default_str();
  command
      .add_option("--elevation", arguments->camera.elevation_deg,
                  "elevation of the view direction, deg; negative: from above")
      ->capture_default_str();
  command.add_option("--distance", arguments->camera.distance, "distance of the camera, m")
      ->capture_default_str();
  command.add_flag("--video", arguments->video,
                   "also video.png, an animated PNG of the whole pick");
  command.add_flag(
      "--posterior", arguments->posterior,
      "also posterior.png, an animated PNG of the poses that are credible after each touch");
  command.add_flag("--gif", arguments->gif,
                   "video.gif and posterior.gif instead, for programs that play no animated PNG");
  command
      .add_option("--speed", arguments->speed, "speed of animations relative to the robot's time")
      ->check(in_range(0.1, 100.0))
      ->capture_default_str();
  add_common_options(command, arguments->common, kConfig | kSeed | kOut);
  command.footer(
      "Writes into DIR: by default where the recording is, whose pictures are drawn again, else\n"
      "out/render-OBJECT-SEED. Needs no screen; palpate doctor reports whether it can draw.\n\n"
      "Examples:\n"
      "  palpate render --object mug --seed 2\n"
      "  palpate render --object box --hand allegro\n"
      "  palpate render --object box --arm ur10\n"
      "  palpate render out/pick-mug-2/recording.h5 --size 640x480 --azimuth 90 --out pictures\n"
      "  palpate render out/pick-mug-2/recording.h5 --size 400x300 --video --gif\n"
      "  palpate render out/pick-mug-2/recording.h5 --size 480x360 --posterior --elevation -30");
  command.callback([arguments, &command, &chosen] {
    check_use(command);
    chosen = [arguments] { return render(*arguments); };
  });
}

}  // namespace palpate::app
