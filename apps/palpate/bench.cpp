// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <memory>
#include <optional>
#include <set>

#include "common.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/simulation/world/open_loop_grasp.hpp"
#include "representations.hpp"

namespace palpate::app {
namespace {

constexpr double kRadius = 0.007;       // m, of a fingertip
constexpr double kDepth = 0.0002;       // m, of the probes
constexpr double kAboveMiddle = 0.015;  // m, of the hand when it closes
constexpr double kMillimetres = 1000;

struct BenchArguments {
  CommonOptions common;
  std::string object = "duck";
  int probes = 400;
  bool quick = false;
};

int probe_count(const BenchArguments& arguments) {
  return arguments.quick ? std::min(arguments.probes, 40) : arguments.probes;
}

nlohmann::json spread(std::vector<double> values, double unit) {
  if (values.empty()) return nullptr;
  for (double& value : values) value *= unit;
  return {
      {"median", median(values)}, {"p95", quantile(values, 0.95)}, {"max", quantile(values, 1)}};
}

nlohmann::json representation_json(const RepresentationResult& result) {
  return {{"angle_deg", spread(result.angles, kDegreesPerRadian)},
          {"position_mm", spread(result.offsets, kMillimetres)},
          {"depth_mm", spread(result.depths, kMillimetres)},
          {"missed", result.missed},
          {"microseconds", result.call_seconds * 1e6},
          {"prepare_seconds", result.prepare_seconds}};
}

nlohmann::json measure_representations(const BenchArguments& arguments) {
  const auto object = geometry::load_known_object(arguments.object);
  const geometry::MeshQuery mesh(object.mesh);
  const auto probes = place_test_spheres(mesh, probe_count(arguments), kRadius, kDepth,
                                         RandomStream(arguments.common.seed, "probes"));
  nlohmann::json results;
  for (const Representation representation : kRepresentations) {
    if (!arguments.common.quiet) fmt::print(stderr, "{}\n", to_string(representation));
    results[std::string(to_string(representation))] =
        representation_json(measure_representation(representation, mesh, probes, kRadius));
  }
  return results;
}

/// Steps of the physics a second of the processor, from when two fingers touch the object.
nlohmann::json measure_grasp(const BenchArguments& arguments, bool exact_tips) {
  simulation::WorldOptions options;
  options.exact_tips = exact_tips;
  const auto object = geometry::load_known_object(arguments.object);
  simulation::World world(object, options, arguments.common.seed);
  std::optional<std::clock_t> start;
  double steps = 0, contacts = 0;
  world.observe([&](const simulation::ObjectStep& step) {
    std::set<int> fingers;
    for (const auto& contact : step.contacts) fingers.insert(contact.finger);
    fingers.erase(-1);
    if (!start && fingers.size() >= 2) start = std::clock();
    if (!start) return;
    steps += 1;
    contacts += static_cast<double>(step.contacts.size());
  });
  simulation::OpenLoopGrasp grasp;
  grasp.side = false;
  grasp.height = object.stable_poses.front().height + kAboveMiddle;
  grasp.start.yaw = 3;
  grasp.hold_seconds = arguments.quick ? 0.2 : 4.0;
  const bool lifted = simulation::run_open_loop_grasp(world, grasp);
  if (!start) throw BadInput(fmt::format("no two fingers reach {}", arguments.object));
  const double seconds = static_cast<double>(std::clock() - *start) / CLOCKS_PER_SEC;
  return {{"steps_per_second", steps / seconds},
          {"times_real_time", steps * options.time_step / seconds},
          {"contacts", contacts / steps},
          {"lifted", lifted}};
}

std::string three(const nlohmann::json& spread, int digits) {
  if (spread.is_null()) return "-";
  return fmt::format("{:.{}f} / {:.{}f} / {:.{}f}", spread["median"].get<double>(), digits,
                     spread["p95"].get<double>(), digits, spread["max"].get<double>(), digits);
}

void print_table(const nlohmann::json& report) {
  fmt::print(
      "{} balls of 7 mm, 0.2 mm deep in {}; median / p95 / max; \"exact\" is what the "
      "fingertips use\n\n{:<8} {:>22} {:>22} {:>22} {:>7} {:>9} {:>9}\n",
      report["probes"].get<int>(), report["object"].get<std::string>(), "", "angle deg",
      "position mm", "depth mm", "missed", "us", "prepare s");
  for (const Representation representation : kRepresentations) {
    const std::string name(to_string(representation));
    const auto& result = report["representations"][name];
    fmt::print("{:<8} {:>22} {:>22} {:>22} {:>7} {:>9.1f} {:>9.2f}\n", name,
               three(result["angle_deg"], 2), three(result["position_mm"], 3),
               three(result["depth_mm"], 3), result["missed"].get<int>(),
               result["microseconds"].get<double>(), result["prepare_seconds"].get<double>());
  }
  fmt::print("\n");
  for (const char* tips : {"exact", "parts"}) {
    const auto& grasp = report["grasp"][tips];
    fmt::print("hand and {} in grasp, tips against {}: {:.0f} steps/s, {:.1f} times real time\n",
               report["object"].get<std::string>(), tips, grasp["steps_per_second"].get<double>(),
               grasp["times_real_time"].get<double>());
  }
}

int bench_contact(const BenchArguments& arguments) {
  geometry::load_known_object(arguments.object);  // a bad one is named before results are lost
  const auto output = claim_output(arguments.common, {"contact.json"});
  const nlohmann::json report = {
      {"object", arguments.object},
      {"seed", arguments.common.seed},
      {"probes", probe_count(arguments)},
      {"representations", measure_representations(arguments)},
      {"grasp",
       {{"exact", measure_grasp(arguments, true)}, {"parts", measure_grasp(arguments, false)}}}};
  if (!arguments.common.out.empty()) {
    write_file_atomically(std::filesystem::path(arguments.common.out) / "contact.json",
                          json_text(report));
  }
  if (arguments.common.json) {
    print_json(report);
  } else {
    print_table(report);
  }
  return kDone;
}

}  // namespace

void add_bench(CLI::App& program, Command& chosen) {
  auto& bench =
      *program.add_subcommand("bench", "Measure components of the pick beside alternatives");
  bench.require_subcommand(1);
  bench.footer("Examples:\n  palpate bench contact --object mug");
  auto arguments = std::make_shared<BenchArguments>();
  auto& command = *bench.add_subcommand(
      "contact", "Fingertip contacts with an object: true surface, hull, convex parts, SDF, flex");
  command
      .add_option("--object", arguments->object,
                  "mug, bottle, box, bracket, duck, or a mesh file in metres")
      ->option_text("O")
      ->capture_default_str();
  command.add_option("--probes", arguments->probes, "balls placed on the surface")
      ->check(in_range(1, 100000))
      ->capture_default_str();
  command.add_flag("--quick", arguments->quick, "few balls and a short grasp, as a smoke test");
  add_common_options(command, arguments->common, kSeed | kOut);
  command.footer(
      "Times are processor times.\n\n"
      "Examples:\n"
      "  palpate bench contact\n"
      "  palpate bench contact --object mug --json --out out/bench");
  command.callback(
      [arguments, &chosen] { chosen = [arguments] { return bench_contact(*arguments); }; });
}

}  // namespace palpate::app
