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
#include "palpate/evaluation/belief_recorder.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/recording/writer.hpp"
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
    name += fmt::format("{}{}", name.empty() ? "" : "+", fs::path(object).stem().string());
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
  return text;
}

/// What was done to the mesh files so that they are closed, by their names.
nlohmann::json repairs_json(const CandidateObjects& objects) {
  auto all = nlohmann::json::object();
  for (std::size_t i = 0; i < objects.models.size(); ++i) {
    const auto& repairs = objects.models[i].object().repairs;
    if (!repairs.empty()) all[objects.names[i]] = repairs;
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

int pick(const PickArguments& arguments) {
  const CommonOptions& common = arguments.common;
  auto options = resolve_trial(common, arguments.hand, arguments.arm);
  if (arguments.explore) {
    options.pick.explore.touches = *arguments.explore;
    options.pick.explore.max_touches = *arguments.explore;
  }
  if (!arguments.place.empty()) options.place.target = place_text(arguments.place);
  apply_place(arguments.known, common.set, options.start);
  check_target(arguments, options.place.target);
  auto given = arguments.objects;
  if (!arguments.true_object.empty()) given.push_back(arguments.true_object);
  require_mesh_file(given, arguments.known.units);
  const std::string names = fmt::format("{}", fmt::join(arguments.objects, ","));
  std::optional<Notice> notice(std::in_place, "preparing " + names, common.quiet);
  const CandidateObjects objects = load_objects(arguments.objects, arguments.known);
  const std::size_t truth = true_index(arguments);
  std::optional<geometry::ObjectModel> other;
  if (truth == objects.names.size()) {
    other.emplace(load_object(arguments.true_object, arguments.known));
  }
  const geometry::ObjectModel& object = other ? *other : objects.models[truth];
  evaluation::check_trial(object.object(), options, common.seed);  // bad ones are named first
  const bool sensor_reported_errors = options.touch.from_biotacs();
  const std::string config = config_header(common) + names_header(arguments) + to_toml(options);
  const Interrupt interrupt;
  const auto live = arguments.live.open(common.quiet);
  // First, so that nothing is left behind where the simulator refuses something.
  const simulation::World world(object.object(), options.world, common.seed);
  notice.reset();

  const fs::path folder = output_folder(arguments);
  const OutputFolder output(folder, {"recording.h5", "config.toml", "report.json", "replay.html"},
                            common.force);
  const recording::RecordingHeader header{
      std::string(version()), common.seed, object.object(),
      world.hand_model(),     config,      sensor_reported_errors};
  const auto title = fmt::format("palpate pick --object {} --seed {}{}", names, common.seed,
                                 arguments.place.empty() ? "" : " --place " + arguments.place);
  recording::Writer writer(folder / "recording.h5", header);
  const auto page = live ? live->begin(header, title) : nullptr;
  std::vector<recording::Sink*> sinks{&writer};
  if (page) sinks.push_back(page.get());
  std::optional<evaluation::BeliefRecorder> beliefs;
  if (objects.models.size() == 1 && !other && !arguments.no_belief) {
    beliefs.emplace(object, header.hand,
                    evaluation::BeliefRecorder::Options{options.pick_options(), {}}, common.seed,
                    [&page](const recording::BeliefRecord& belief) {
                      if (page) page->belief(belief);
                    });
    sinks.push_back(&*beliefs);
  }
  recording::Tee sink(std::move(sinks));
  const auto trial = evaluation::run_trial(object, objects.candidates(), options, common.seed,
                                           &sink, phase_printer(common), interrupt.token());
  notice.emplace("writing the recording and its page", common.quiet);
  if (beliefs) {
    for (const auto& belief : beliefs->finish()) writer.belief(belief);
  }
  writer.finish();
  if (page) page->end(trial.result.held ? "picked" : "ended: " + trial.result.failed_phase);
  write_file_atomically(folder / "config.toml", config);
  auto report = trial_json(trial, objects.names);
  auto repairs = repairs_json(objects);
  if (other && !object.object().repairs.empty()) {
    repairs[arguments.true_object] = object.object().repairs;
  }
  report.update(
      {{"object", names}, {"seed", common.seed}, {"version", version()}, {"repairs", repairs}});
  write_file_atomically(folder / "report.json", json_text(report));
  write_file_atomically(folder / "replay.html", replay_html(folder / "recording.h5", title));
  notice.reset();
  if (common.json) {
    print_json(report);
  } else {
    for (const auto& [name, done] : repairs.items()) print_repairs(name, done);
    fmt::print("{}\n{}wrote {}: recording.h5, config.toml, report.json, replay.html\n",
               outcome_text(trial, objects.names), place_text(trial), folder.string());
    print_next(common, fmt::format("open {}/replay.html in a browser, or palpate view {}",
                                   folder.string(), quoted((folder / "recording.h5").string())));
  }
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
  add_hand_option(command, arguments->hand);
  add_arm_option(command, arguments->arm);
  command
      .add_option("--explore", arguments->explore,
                  "touches of the resting object before the grasp, in at most twice as many "
                  "guarded moves; 0: none (default: 8 moves, and up to 16 while the pose is "
                  "ambiguous)")
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
