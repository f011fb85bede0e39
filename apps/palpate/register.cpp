// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/geometry/cloud/outlier_filter.hpp"
#include "palpate/geometry/io/point_cloud_io.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "palpate/registration/correspondences_io.hpp"
#include "register_report.hpp"
#include "terminal.hpp"
#include "units_hint.hpp"

namespace palpate::app {
namespace {

namespace rg = registration;

struct RegisterArguments {
  CommonOptions common;
  std::string source, target, features = "fpfh";
  std::string correspondences;
  std::string method = "clique+gnc", cost = "tls", initial;
  std::optional<std::string> primitive;
  std::optional<double> noise_bound, normal_noise_deg, known_scale;
  std::vector<double> gravity;
  bool filter = false, yaw_only = false, translation_only = false, scale = false,
       best_effort = false;
  int repeats = 1, instances = 1;
};

/// All options that a configuration may set; those of features only matter to clouds.
struct RegisterOptions {
  /// A person waits longer for an answer than a program: its bound comes with it.
  rg::RegistrationOptions registration = {
      .robust_bound = {.max_nodes = 100000, .max_seconds = 0.2}};
  rg::FeatureOptions features;
  geometry::OutlierFilterOptions filter;

  template <class Visitor>
  void visit(Visitor&& v) {
    registration.visit(v);
    v.section("features", features);
    v("filter_neighbours", filter.neighbours, 1, 1000000, "neighbours of the outlier filter");
    v("filter_deviation_ratio", filter.deviation_ratio, 1e-6, 1e6,
      "standard deviations above the mean distance that the outlier filter keeps");
  }
};

RegisterOptions options_of(const RegisterArguments& arguments) {
  auto options = resolve<RegisterOptions>(arguments.common);
  auto& registration = options.registration;
  registration.method = arguments.method == "gnc" ? rg::Method::kGnc : rg::Method::kCliqueGnc;
  registration.cost = arguments.cost == "gm" ? rg::RobustCost::kGemanMcClure
                                             : rg::RobustCost::kTruncatedLeastSquares;
  const std::string usual = arguments.correspondences.empty() ? "plane" : "point";
  registration.primitive = arguments.primitive.value_or(usual) == "plane" ? rg::Primitive::kPlane
                                                                          : rg::Primitive::kPoint;
  if (!arguments.initial.empty()) registration.initial = parse_pose(arguments.initial);
  if (arguments.yaw_only) registration.rotation_axis = Eigen::Vector3d::UnitZ();
  if (!arguments.gravity.empty()) {
    registration.rotation_axis = Eigen::Vector3d::Map(arguments.gravity.data());
  }
  registration.translation_only = arguments.translation_only;
  registration.estimate_scale = arguments.scale;
  registration.instances = arguments.instances;
  registration.best_effort = registration.best_effort || arguments.best_effort;
  registration.seed = arguments.common.seed;
  registration.keep_history = !arguments.common.out.empty();
  if (arguments.noise_bound) registration.noise_bound = *arguments.noise_bound;
  if (arguments.normal_noise_deg) registration.normal_noise_deg = *arguments.normal_noise_deg;
  return options;
}

/// Whether too few pairs count at all.
std::string weights_hint(const std::vector<double>& weights) {
  const auto count = std::ranges::count_if(weights, [](double w) { return w > 0; });
  if (weights.empty() || count >= 3) return "";
  return fmt::format("{} of {} pairs have a weight above 0; three are the least", count,
                     weights.size());
}

/// Refuses options that would have no effect on these pairs.
void check_pairs(const rg::Correspondences& pairs, const RegisterArguments& arguments) {
  if (arguments.method == "gnc" && !arguments.initial.empty()) {
    throw BadInput("--initial goes with cliques, not with --method gnc, which needs no start");
  }
  if (arguments.normal_noise_deg.value_or(0) > 0 && !pairs.has_normals()) {
    throw BadInput(fmt::format("--normal-noise-deg needs normals: {} has no columns snx, ..., tnz",
                               arguments.correspondences));
  }
}

/// Result, and what only clouds have.
struct Outcome {
  rg::CloudRegistration registration;
  bool clouds = false;
  geometry::PointCloud source;  ///< after a known scale
  double estimated_scale = 1;   ///< of that
  std::string hint;             ///< why there may be no pose
};

geometry::PointCloud load(const std::string& path, const RegisterArguments& arguments,
                          const RegisterOptions& options) {
  geometry::PointCloud cloud = geometry::load_cloud(path);
  if (!arguments.filter) return cloud;
  return geometry::subset(cloud, geometry::statistical_inliers(cloud, options.filter));
}

void scale_points(std::vector<Eigen::Vector3d>& points, double scale) {
  for (auto& p : points) p *= scale;
}

void apply_known_scale(std::vector<Eigen::Vector3d>& points, const RegisterArguments& arguments) {
  scale_points(points, arguments.known_scale.value_or(1));
}

Outcome find_pose(const RegisterArguments& arguments, const RegisterOptions& options) {
  const Notice notice("registering", arguments.common.quiet);
  Outcome outcome;
  auto& result = outcome.registration.result;
  auto& correspondences = outcome.registration.correspondences;
  if (!arguments.correspondences.empty()) {
    correspondences = rg::read_correspondences(arguments.correspondences);
    check_pairs(correspondences, arguments);
    apply_known_scale(correspondences.source, arguments);
    result = rg::register_correspondences(correspondences, options.registration);
    for (int k = 1; k < arguments.repeats; ++k) {
      auto again = rg::register_correspondences(correspondences, options.registration);
      if (again.seconds < result.seconds) result = std::move(again);
    }
    outcome.hint = units_hint(correspondences.source, correspondences.target,
                              options.registration.noise_bound);
    if (outcome.hint.empty()) outcome.hint = weights_hint(correspondences.weights);
    if (outcome.hint.empty()) outcome.hint = reason_of(result, options.registration);
    return outcome;
  }
  outcome.clouds = true;
  outcome.source = load(arguments.source, arguments, options);
  apply_known_scale(outcome.source.points, arguments);
  const geometry::PointCloud target = load(arguments.target, arguments, options);
  outcome.registration = rg::register_clouds(outcome.source, target,
                                             {.features = options.features,
                                              .registration = options.registration,
                                              .noise_bound = arguments.noise_bound,
                                              .threads = arguments.common.threads});
  outcome.hint =
      units_hint(outcome.source.points, target.points, arguments.noise_bound.value_or(0));
  if (outcome.hint.empty()) outcome.hint = reason_of(outcome.registration, options.registration);
  return outcome;
}

nlohmann::json outcome_report(const Outcome& outcome) {
  auto report = report_of(outcome.registration.result);
  report["hint"] = outcome.registration.result.T_target_source ? "" : outcome.hint;
  if (!outcome.clouds) return report;
  report["correspondences"] = outcome.registration.correspondences.size();
  report["feature_matches"] = outcome.registration.feature_matches;
  report["feature_inliers"] = outcome.registration.feature_inliers;
  report["voxel"] = outcome.registration.voxel;
  report["noise_bound"] = outcome.registration.noise_bound;
  report["refinements"] = outcome.registration.refinements;
  report["overlap"] = outcome.registration.overlap;
  report["contradiction"] = outcome.registration.contradiction;
  report["rms_error"] = outcome.registration.rms_error;
  report["feature_seconds"] = outcome.registration.feature_seconds;
  return report;
}

void write_results(const CommonOptions& common, const RegisterOptions& options,
                   const Outcome& outcome) {
  if (common.out.empty()) return;
  const std::filesystem::path folder = common.out;
  const auto output = claim_output(common, {"report.json", "config.toml", "correspondences.csv",
                                            "weights.csv", "source_in_target.ply"});
  const auto& result = outcome.registration.result;
  write_file_atomically(folder / "report.json", json_text(outcome_report(outcome)));
  write_file_atomically(folder / "config.toml", config_header(common) + to_toml(options));
  write_file_atomically(folder / "correspondences.csv",
                        correspondences_csv(outcome.registration.correspondences, result));
  if (!result.history.empty()) {
    write_file_atomically(folder / "weights.csv", weight_history_csv(result.history));
  }
  if (outcome.clouds && result.T_target_source) {
    geometry::PointCloud placed = outcome.source;
    scale_points(placed.points, outcome.estimated_scale);
    geometry::save_cloud(folder / "source_in_target.ply",
                         geometry::transformed(*result.T_target_source, std::move(placed)));
  }
}

/// Where the answer can be seen or checked.
void print_next_of(const RegisterArguments& arguments, const CLI::App& command,
                   const Outcome& outcome) {
  const std::string& out = arguments.common.out;
  if (!outcome.registration.result.T_target_source) return;
  if (out.empty()) {
    print_next(arguments.common,
               fmt::format("{} --out out/register writes {}", given_command(command),
                           outcome.clouds ? arguments.source + " as it lies in the target"
                                          : "which pairs are inliers"));
    return;
  }
  print_next(arguments.common,
             outcome.clouds
                 ? fmt::format("compare {}/source_in_target.ply with {} in a viewer of clouds", out,
                               arguments.target)
                 : fmt::format("{}/correspondences.csv lists inliers and outliers", out));
}

int register_command(const RegisterArguments& arguments, const CLI::App& command) {
  const auto options = options_of(arguments);
  Outcome outcome = find_pose(arguments, options);
  outcome.estimated_scale = outcome.registration.result.scale;
  outcome.registration.result.scale *= arguments.known_scale.value_or(1);
  const rg::RegistrationResult& result = outcome.registration.result;
  write_results(arguments.common, options, outcome);
  if (arguments.common.json) {
    print_json(outcome_report(outcome));
  } else {
    print_report(result, outcome.hint, !outcome.clouds || !options.registration.initial);
    outcome.clouds ? print_features(outcome.registration) : print_bound(result);
    print_next_of(arguments, command, outcome);
  }
  return result.status == rg::RegistrationStatus::kFound ? kDone : kNoSolution;
}

void add_inputs(CLI::App& command, RegisterArguments& arguments) {
  auto* source = command.add_option("source", arguments.source,
                                    "cloud or mesh to place: PLY, STL, OBJ, PCD or XYZ, in metres");
  auto* target = command.add_option("target", arguments.target, "cloud or mesh to place it in");
  auto* correspondences =
      command
          .add_option("--correspondences", arguments.correspondences,
                      "CSV with sx,sy,sz,tx,ty,tz[,snx,sny,snz,tnx,tny,tnz,weight] in metres")
          ->option_text("FILE");
  source->needs(target);
  correspondences->excludes(source);
  command
      .add_option("--features", arguments.features,
                  "descriptor by which points of clouds are matched, of which this is the only one "
                  "yet")
      ->check(CLI::IsMember({"fpfh"}))
      ->excludes(correspondences)
      ->capture_default_str();
  command
      .add_flag("--filter", arguments.filter,
                "first remove statistical outliers of clouds (1000 neighbours, ratio 0.5)")
      ->excludes(correspondences);
}

void add_problem(CLI::App& command, RegisterArguments& arguments) {
  command
      .add_option("--initial", arguments.initial,
                  "start from this T_target_source instead of a search: 16 numbers, row-major, or "
                  "a file of them")
      ->option_text("POSE");
  auto* yaw = command.add_flag("--yaw-only", arguments.yaw_only,
                               "estimate rotation about z only; both frames have z along gravity");
  auto* gravity =
      command
          .add_option("--gravity", arguments.gravity,
                      "estimate rotation about this direction only, the same in both frames")
          ->option_text("X Y Z")
          ->expected(3)
          ->excludes(yaw);
  command
      .add_flag("--translation-only", arguments.translation_only,
                "estimate translation only; both frames have the same orientation")
      ->excludes(yaw)
      ->excludes(gravity);
  auto* estimated =
      command.add_flag("--scale", arguments.scale, "estimate the scale of the source as well");
  command
      .add_option("--known-scale", arguments.known_scale,
                  "multiply the source's coordinates by this first")
      ->option_text("S")
      ->check(in_range(1e-9, 1e9))
      ->excludes(estimated);
  command
      .add_option("--instances", arguments.instances,
                  "number of poses, each found in the pairs or points that remain")
      ->option_text("N")
      ->check(in_range(1, 1000));
  command.add_flag("--best-effort", arguments.best_effort,
                   "report the best pose even if chance explains it (see false_alarms)");
}

void add_method(CLI::App& command, RegisterArguments& arguments) {
  command
      .add_option(
          "--noise-bound", arguments.noise_bound,
          "largest position error of an inlier, m: four standard deviations (0.004; clouds: "
          "1.5 times the distance between points)")
      ->option_text("M")
      ->check(positive());
  command
      .add_option(
          "--normal-noise-deg", arguments.normal_noise_deg,
          "standard deviation of normals per axis, deg, to find inliers by them, too (0: do not)")
      ->option_text("DEG");
  command
      .add_option("--primitive", arguments.primitive,
                  "residuals of the final solve: point or plane (default: point; clouds: plane)")
      ->check(CLI::IsMember({"point", "plane"}));
  command.add_option("--method", arguments.method, "how inliers are found")
      ->check(CLI::IsMember({"clique+gnc", "gnc"}))
      ->capture_default_str();
  command
      .add_option("--repeats", arguments.repeats,
                  "repeat the solution of given correspondences and report the shortest times")
      ->check(in_range(1, 1000))
      ->capture_default_str();
  command.add_option("--cost", arguments.cost, "robust cost of gnc")
      ->check(CLI::IsMember({"tls", "gm"}))
      ->capture_default_str();
}

}  // namespace

std::vector<OptionInfo> register_option_list() { return list_options(RegisterOptions{}); }

void add_register(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<RegisterArguments>();
  auto& command = *program.add_subcommand(
      "register", "Register two clouds or meshes, by features or given correspondences");
  add_inputs(command, *arguments);
  add_problem(command, *arguments);
  add_method(command, *arguments);
  add_common_options(command, arguments->common);
  command.footer(
      "Statuses: found, degenerate (the motions in free_motions change nothing), no_consensus\n"
      "(chance explains the agreement, or the surfaces contradict one another). The last\n"
      "two have no pose and exit with 4.\n"
      "certificate.least_squares: no pose fits the chosen inliers better;\n"
      "certificate.robust_bound: no pose has more inliers than that.\n"
      "--out receives report.json, config.toml, correspondences.csv,\n"
      "weights.csv (the history of gnc's weights) and, for clouds, source_in_target.ply.\n\n"
      "Examples:\n"
      "  palpate register scan.ply model.stl --out out/scan\n"
      "  palpate register scan.ply model.stl --initial pose.txt\n"
      "  palpate register scan.ply map.ply --gravity 0 0 -1\n"
      "  palpate register scan_mm.ply model.stl --known-scale 0.001\n"
      "  palpate register photos.ply model.stl --scale\n"
      "  palpate register mug.stl table.ply --instances 5\n"
      "  palpate register --correspondences pairs.csv --noise-bound 0.004\n"
      "  palpate register --correspondences pairs.csv --method gnc --cost gm --json");
  command.callback([arguments, &command, &chosen] {
    if (arguments->correspondences.empty() && arguments->target.empty()) {
      throw CLI::RequiredError("SOURCE and TARGET, or --correspondences FILE");
    }
    if (command.count("--cost") > 0 && arguments->method != "gnc") {
      throw CLI::RequiresError("--cost", "--method gnc");
    }
    const bool clouds = arguments->correspondences.empty();
    if (clouds && command.count("--repeats") > 0) {
      throw CLI::RequiresError("--repeats", "--correspondences");
    }
    if (!clouds && command.count("--threads") > 0) {
      throw CLI::ExcludesError("--correspondences", "--threads");
    }
    chosen = [arguments, &command] { return register_command(*arguments, command); };
  });
}

}  // namespace palpate::app
