// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "common.hpp"
#include "given_command.hpp"
#include "hand_option.hpp"
#include "interrupt.hpp"
#include "live_view.hpp"
#include "object_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/version.hpp"
#include "palpate/evaluation/trial.hpp"
#include "pick_recording.hpp"
#include "pick_report.hpp"
#include "place_report.hpp"
#include "replay_file.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct PickArguments {
  CommonOptions common;
  std::vector<std::string> objects = {"mug"};
  std::string true_object;
  ObjectArguments known;
  std::string hand, arm;
  std::optional<int> explore;
  std::string place;
  LiveOption live;
  bool no_belief = false;
};

fs::path output_folder(const PickArguments& arguments) {
  if (!arguments.common.out.empty()) return arguments.common.out;
  std::string name;
  for (const auto& object : arguments.objects) {
    name += fmt::format("{}{}", name.empty() ? "" : "+", short_name(object));
  }
  return fs::path("out") / fmt::format("pick-{}-{}", name, arguments.common.seed);
}

/// Index of the object that stands there: the one of that name, or drawn by the seed. One that is
/// none of those given comes after them.
std::size_t true_index(const PickArguments& arguments) {
  const auto& names = arguments.objects;
  if (names.size() > 1 && arguments.true_object.empty()) {
    return RandomStream(arguments.common.seed, "object").index(names.size());
  }
  if (arguments.true_object.empty()) return 0;
  const auto found = std::ranges::find_if(
      names, [&](const std::string& name) { return is_same_object(name, arguments.true_object); });
  return static_cast<std::size_t>(found - names.begin());
}

/// A target is that of an object which is known.
void check_target(const PickArguments& arguments, const std::string& target) {
  if (target.empty()) return;
  if (arguments.objects.size() > 1) {
    throw BadInput(fmt::format("--place {}: needs one object, {} are given", target,
                               arguments.objects.size()));
  }
  if (arguments.known.size_range > 0) {
    throw BadInput(fmt::format("--place {}: needs an object of known size, and --size-range is {}",
                               target, arguments.known.size_range));
  }
  if (true_index(arguments) == 0) return;
  throw BadInput(
      fmt::format("--place {}: needs an object that is known, and --true-object {} is "
                  "not {}",
                  target, arguments.true_object, arguments.objects.front()));
}

/// Comments of the configuration that say of what the pick was.
std::string names_header(const PickArguments& arguments) {
  std::string text = fmt::format("# object {}\n", fmt::join(arguments.objects, ","));
  if (!arguments.true_object.empty()) {
    text += fmt::format("# true object {}\n", arguments.true_object);
  }
  if (arguments.known.size_range > 0) {
    text += fmt::format("# size range {}\n", arguments.known.size_range);
  }
  return text;
}

/// Of the objects that it may be, as they were given.
std::string names_of(const PickArguments& arguments) {
  return fmt::format("{}", fmt::join(arguments.objects, ","));
}

/// The objects that it may be, and the one that stands there.
struct PickObjects {
  CandidateObjects candidates;
  std::size_t truth = 0;                       ///< index of what stands there
  std::optional<geometry::ObjectModel> other;  ///< that, if it is none of the candidates

  [[nodiscard]] const geometry::ObjectModel& present() const {
    return other ? *other : candidates.models[truth];
  }
  [[nodiscard]] bool known() const { return candidates.models.size() == 1 && !other; }
};

PickObjects load_pick_objects(const PickArguments& arguments) {
  PickObjects objects{load_objects(arguments.objects, arguments.known), true_index(arguments), {}};
  if (objects.truth < arguments.objects.size()) return objects;
  if (const auto* model = objects.candidates.find(arguments.true_object)) {  // another size
    objects.truth = static_cast<std::size_t>(model - objects.candidates.models.data());
  } else {
    objects.other.emplace(load_object(arguments.true_object, arguments.known));
  }
  return objects;
}

/// What was done to the mesh files so that they are closed, by their names.
nlohmann::json repairs_json(const PickArguments& arguments, const PickObjects& objects) {
  auto all = nlohmann::json::object();
  for (std::size_t i = 0; i < objects.candidates.models.size(); ++i) {
    const auto& repairs = objects.candidates.models[i].object().repairs;
    if (!repairs.empty()) all[objects.candidates.names[i]] = repairs;
  }
  if (objects.other && !objects.other->object().repairs.empty()) {
    all[arguments.true_object] = objects.other->object().repairs;
  }
  return all;
}

/// Prints the phases as they end, and on a terminal the one that runs.
skills::PhaseObserver phase_printer(const CommonOptions& common) {
  if (common.json) return {};
  fmt::print("{}\n", phase_heading());
  const auto notice = std::make_shared<std::optional<Notice>>();
  return {[notice, quiet = common.quiet](std::string_view phase, double) {
            notice->emplace(std::string(phase), quiet);
          },
          [notice](const skills::PhaseReport& report, double) {
            notice->reset();
            fmt::print("{}\n", phase_row(report));
            std::fflush(stdout);
          }};
}

/// @throws BadInput for arguments that do not go together
evaluation::TrialOptions options_of(const PickArguments& arguments) {
  auto options = resolve_trial(arguments.common, arguments.hand, arguments.arm);
  if (arguments.explore) {
    options.pick.explore.touches = *arguments.explore;
    options.pick.explore.max_touches = *arguments.explore;
  }
  if (!arguments.place.empty()) options.place.target = place_text(arguments.place);
  apply_place(arguments.known, arguments.common.set, options.start);
  check_target(arguments, options.place.target);
  auto given = arguments.objects;
  if (!arguments.true_object.empty()) given.push_back(arguments.true_object);
  require_mesh_file(given, arguments.known.units);
  return options;
}

/// @throws BadInput for what the simulator refuses
recording::RecordingHeader header_of(const PickArguments& arguments,
                                     const evaluation::TrialOptions& options,
                                     const geometry::KnownObject& object) {
  const CommonOptions& common = arguments.common;
  const std::string config = config_header(common) + names_header(arguments) + to_toml(options);
  const simulation::World world(object, options.world, common.seed);
  return {std::string(version()), common.seed, object,
          world.hand_model(),     config,      options.touch.from_biotacs()};
}

/// Writes what a pick leaves in its folder beside the recording. @return report.json
nlohmann::json write_results(const PickArguments& arguments, const PickObjects& objects,
                             const evaluation::Trial& trial, const std::string& config,
                             const std::string& title) {
  const fs::path folder = output_folder(arguments);
  write_file_atomically(folder / "config.toml", config);
  auto report = trial_json(trial, objects.candidates.names);
  report.update({{"object", names_of(arguments)},
                 {"seed", arguments.common.seed},
                 {"version", version()},
                 {"repairs", repairs_json(arguments, objects)}});
  write_file_atomically(folder / "report.json", json_text(report));
  write_file_atomically(folder / "replay.html", replay_html(folder / "recording.h5", title));
  return report;
}

void print_pick(const PickArguments& arguments, const nlohmann::json& report,
                const evaluation::Trial& trial, const std::vector<std::string>& names) {
  if (arguments.common.json) return print_json(report);
  const fs::path folder = output_folder(arguments);
  for (const auto& [name, done] : report["repairs"].items()) print_repairs(name, done);
  fmt::print("{}\n{}wrote {}: recording.h5, config.toml, report.json, replay.html\n",
             outcome_text(trial, names), place_text(trial), folder.string());
  print_next(arguments.common, fmt::format("open {} in a browser, or palpate view {}",
                                           quoted((folder / "replay.html").string()),
                                           quoted((folder / "recording.h5").string())));
}

int pick(const PickArguments& arguments) {
  const CommonOptions& common = arguments.common;
  const auto options = options_of(arguments);
  const std::string names = names_of(arguments);
  std::optional<Notice> notice(std::in_place, "preparing " + names, common.quiet);
  const PickObjects objects = load_pick_objects(arguments);
  const geometry::ObjectModel& object = objects.present();
  evaluation::check_trial(object.object(), options, common.seed);  // bad ones are named first
  const Interrupt interrupt;
  notice.reset();
  const auto live = arguments.live.open(common.quiet);
  // First, so that nothing is left behind where the simulator refuses something.
  const auto header = header_of(arguments, options, object.object());

  const fs::path folder = output_folder(arguments);
  const OutputFolder output(folder, {"recording.h5", "config.toml", "report.json", "replay.html"},
                            common.force);
  const double size_range = arguments.known.size_range;
  const auto title =
      fmt::format("palpate pick --object {}{} --seed {}{}", names,
                  size_range > 0 ? fmt::format(" --size-range {}", size_range) : "", common.seed,
                  arguments.place.empty() ? "" : " --place " + arguments.place);
  PickRecording recording(folder / "recording.h5", header,
                          live ? live->begin(header, title) : nullptr);
  if (objects.known() && !arguments.no_belief) {
    recording.follow_belief(object, header.hand, options.pick_options(), common.seed);
  }
  auto sink = recording.sink();
  const auto trial =
      evaluation::run_trial(object, objects.candidates.candidates(), options, common.seed, &sink,
                            phase_printer(common), interrupt.token());

  notice.emplace("writing the recording and its page", common.quiet);
  recording.finish(trial.result);
  const auto report = write_results(arguments, objects, trial, header.config_toml, title);
  notice.reset();
  print_pick(arguments, report, trial, objects.candidates.names);
  if (trial.result.fault) return kStopped;
  return report["status"] == "ok" ? kDone : kNoSolution;
}

}  // namespace

std::vector<OptionInfo> pick_option_list() { return list_options(evaluation::TrialOptions{}); }

void add_pick(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<PickArguments>();
  auto& command = *program.add_subcommand(
      "pick", "Explore, grasp and lift an object, and estimate its pose in the hand by touch");
  command
      .add_option(
          "--object", arguments->objects,
          "mug, bottle, box, bracket, duck, generated:SEED, or a mesh file (see --units); of "
          "several candidates, up to 10, the one present is identified as well")
      ->delimiter(',')
      ->option_text("O[,O2..]")
      ->capture_default_str();
  command
      .add_option("--true-object", arguments->true_object,
                  "object that is simulated, if several are candidates: one of them or another "
                  "one (default: drawn by the seed)")
      ->option_text("O");
  add_object_options(command, arguments->known);
  add_size_range_option(command, arguments->known.size_range);
  add_hand_option(command, arguments->hand);
  add_arm_option(command, arguments->arm);
  command
      .add_option("--explore", arguments->explore,
                  "touches of the resting object before the grasp, in at most twice as many "
                  "guarded moves, and up to explore.refining more that refine the pose; 0: none "
                  "(default: 8 moves, and up to 16 while the pose is ambiguous)")
      ->check(in_range(0, 64));
  add_place_option(command, arguments->place);
  add_live_option(command, arguments->live);
  command.add_flag("--no-belief", arguments->no_belief,
                   "do not compute and record the posterior of the pose after each touch");
  add_common_options(command, arguments->common, kConfig | kSeed | kOut);
  command.footer(
      "Writes recording.h5, config.toml, report.json and replay.html (open it in a browser) into\n"
      "DIR, by default out/pick-OBJECT-SEED. Exit code 4: grasp or placement failed; 3: the "
      "target\n"
      "is impossible, and nothing has moved. A fault of the hand, or Ctrl-C, stops the robot in a\n"
      "safe state: exit code 5, and the report names the fault (docs/safety.md).\n\n"
      "Examples:\n"
      "  palpate pick --object mug --seed 2\n"
      "  palpate pick --object mug --live          # http://127.0.0.1:8080/ while it happens\n"
      "  palpate pick --object duck --explore 16\n"
      "  palpate pick --object mug,box,bottle --seed 7\n"
      "  palpate pick --object mug,box,bottle --true-object bracket --seed 7\n"
      "  palpate pick --object mug --size-range 0.1 --true-object mug@1.07 --seed 7\n"
      "  palpate pick --hand my_hand.xml --object box\n"
      "  palpate pick --arm ur10 --object box --seed 7\n"
      "  palpate pick --object part.stl --set lift.height=0.15 --out run1 --json\n"
      "  palpate pick --object box --set start.stable_pose=0 --set world.noise.normal=0.05\n"
      "  palpate pick --object can.ply --mass 0.349 --at 0.1,-0.05,0.03\n"
      "  palpate pick --object box --place 0.2,0.1,1.57\n"
      "  palpate pick --object bottle --set start.stable_pose=0 --place fixture");
  command.callback([arguments, &chosen] { chosen = [arguments] { return pick(*arguments); }; });
}

}  // namespace palpate::app
