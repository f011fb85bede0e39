// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <chrono>
#include <numbers>
#include <sstream>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/registration/correspondences_io.hpp"
#include "palpate/registration/registration.hpp"

namespace palpate::app {
namespace {

namespace rg = registration;

struct RegisterArguments {
  CommonOptions common;
  std::string correspondences;
  std::string pose;  ///< of certify
  std::string method = "clique+gnc", primitive = "point", cost = "tls";
  std::optional<double> noise_bound, normal_noise_deg;
};

rg::Primitive primitive_of(const RegisterArguments& arguments) {
  return arguments.primitive == "plane" ? rg::Primitive::kPlane : rg::Primitive::kPoint;
}

rg::RegistrationOptions options_of(const RegisterArguments& arguments) {
  auto options = resolve<rg::RegistrationOptions>(arguments.common);
  options.method = arguments.method == "gnc" ? rg::Method::kGnc : rg::Method::kCliqueGnc;
  options.cost = arguments.cost == "gm" ? rg::RobustCost::kGemanMcClure
                                        : rg::RobustCost::kTruncatedLeastSquares;
  options.primitive = primitive_of(arguments);
  options.seed = arguments.common.seed;
  if (arguments.noise_bound) options.noise_bound = *arguments.noise_bound;
  if (arguments.normal_noise_deg) options.normal_noise_deg = *arguments.normal_noise_deg;
  return options;
}

nlohmann::json rows_json(const Matrix6d& matrix) {
  auto rows = nlohmann::json::array();
  for (int i = 0; i < 6; ++i) {
    auto row = nlohmann::json::array();
    for (int j = 0; j < 6; ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

nlohmann::json result_json(const rg::RegistrationResult& result) {
  nlohmann::json pose;  // null
  if (result.T_target_source) pose = to_json(*result.T_target_source);
  return {{"status", rg::to_string(result.status)},
          {"T_target_source", pose},
          {"cost", result.cost},
          {"bound", result.bound},
          {"inliers", result.inliers},
          {"weights", result.weights},
          {"residuals", result.residuals},
          {"iterations", result.iterations},
          {"expected_by_chance", result.expected_by_chance},
          {"information_rank", result.rank},
          {"information", rows_json(result.information)},
          {"search_seconds", result.search_seconds},
          {"solve_seconds", result.solve_seconds},
          {"seconds", result.seconds}};
}

std::string pose_text(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d w = log_so3(T.linear()) * 180 / std::numbers::pi, t = T.translation();
  return fmt::format(
      "rotation ({:.3f}, {:.3f}, {:.3f}) deg, translation ({:.6g}, {:.6g}, {:.6g}) m", w[0], w[1],
      w[2], t[0], t[1], t[2]);
}

void print_result(const rg::RegistrationResult& result) {
  fmt::print("{}: {} of {} correspondences are inliers, {:.2f} ms\n", rg::to_string(result.status),
             result.inliers.size(), result.weights.size(), 1e3 * result.seconds);
  if (result.T_target_source) {
    fmt::print("target from source: {}\n", pose_text(*result.T_target_source));
    fmt::print(
        "cost {:.3g} m^2, at most {:.1g} m^2 above the least; chance proposes {:.1g} such "
        "poses\n",
        result.cost, result.bound, result.expected_by_chance);
  }
}

void write_results(const CommonOptions& common, const rg::RegistrationOptions& options,
                   const nlohmann::json& report) {
  if (common.out.empty()) return;
  const std::filesystem::path folder = common.out;
  write_file_atomically(folder / "report.json", report.dump(2) + "\n");
  write_file_atomically(folder / "config.toml", config_header(common) + to_toml(options));
}

int register_clouds(const RegisterArguments& arguments) {
  const auto options = options_of(arguments);
  const auto correspondences = rg::read_correspondences(arguments.correspondences);
  const auto result = rg::register_correspondences(correspondences, options);
  const auto report = result_json(result);
  write_results(arguments.common, options, report);
  if (arguments.common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    print_result(result);
  }
  const bool pose_known =
      result.status == rg::Status::kCertified || result.status == rg::Status::kUncertified;
  return pose_known ? kDone : kNoSolution;
}

/// 16 numbers, separated by commas or blanks, from the argument itself or the file that it names.
Eigen::Isometry3d parse_pose(const std::string& argument) {
  std::string text = argument;
  std::error_code error;
  if (std::filesystem::is_regular_file(argument, error)) text = read_file(argument);
  for (char& c : text) c = c == ',' || c == '[' || c == ']' ? ' ' : c;
  std::istringstream in(text);
  std::array<double, 16> values{};
  std::size_t count = 0;
  for (double value; in >> value; ++count) {
    if (count < values.size()) values[count] = value;
  }
  if (count != values.size() || !in.eof()) {
    throw BadInput(fmt::format("'{}' is not 16 numbers (nor a file of them), row-major", argument));
  }
  return pose_from_row_major(values);
}

int certify(const RegisterArguments& arguments) {
  const Eigen::Isometry3d T = parse_pose(arguments.pose);
  const auto primitive = primitive_of(arguments);
  auto correspondences = rg::read_correspondences(arguments.correspondences);
  const auto start = std::chrono::steady_clock::now();
  if (arguments.noise_bound) {
    const auto squared = rg::squared_residuals(correspondences, T, rg::Primitive::kPoint);
    std::vector<int> inliers;
    for (std::size_t i = 0; i < squared.size(); ++i) {
      if (std::sqrt(squared[i]) <= *arguments.noise_bound) inliers.push_back(static_cast<int>(i));
    }
    correspondences = rg::subset(correspondences, inliers);
  }
  const auto estimate = rg::certify(T, correspondences, {}, primitive);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  const nlohmann::json report = {{"status", rg::to_string(estimate.status)},
                                 {"cost", estimate.cost},
                                 {"bound", estimate.bound},
                                 {"reference", estimate.reference},
                                 {"correspondences", correspondences.size()},
                                 {"information_rank", estimate.rank},
                                 {"seconds", elapsed.count()}};
  if (arguments.common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    fmt::print("{}: cost {:.6g} m^2 of {} correspondences, at most {:.2g} m^2 above the least\n",
               rg::to_string(estimate.status), estimate.cost, correspondences.size(),
               estimate.bound);
  }
  return estimate.status == rg::Status::kCertified ? kDone : kNoSolution;
}

void add_shared_options(CLI::App& command, RegisterArguments& arguments) {
  command
      .add_option("--correspondences", arguments.correspondences,
                  "CSV with sx,sy,sz,tx,ty,tz[,snx,sny,snz,tnx,tny,tnz] in metres")
      ->option_text("FILE")
      ->required();
  command.add_option("--primitive", arguments.primitive, "what residuals are: point or plane")
      ->check(CLI::IsMember({"point", "plane"}))
      ->capture_default_str();
  add_common_options(command, arguments.common);
}

}  // namespace

void add_register(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<RegisterArguments>();
  auto& command = *program.add_subcommand(
      "register", "Find the pose of one cloud in another from correspondences, most of them wrong");
  add_shared_options(command, *arguments);
  command
      .add_option("--noise-bound", arguments->noise_bound,
                  "largest position error of an inlier, m: four standard deviations (0.004)")
      ->option_text("M");
  command
      .add_option("--normal-noise-deg", arguments->normal_noise_deg,
                  "noise of normals per axis, deg; uses them to find inliers (0: not)")
      ->option_text("DEG");
  command.add_option("--method", arguments->method, "how inliers are found")
      ->check(CLI::IsMember({"clique+gnc", "gnc"}))
      ->capture_default_str();
  command.add_option("--cost", arguments->cost, "robust cost of gnc")
      ->check(CLI::IsMember({"tls", "gm"}))
      ->capture_default_str();
  command.footer(
      "Statuses: certified, uncertified (the bound says by how much the pose may miss the best),\n"
      "degenerate (a motion is left free), no_consensus (chance explains the agreement).\n"
      "The last two exit with 4.\n\n"
      "Examples:\n"
      "  palpate register --correspondences pairs.csv --noise-bound 0.004\n"
      "  palpate register --correspondences pairs.csv --method gnc --cost gm --json");
  command.callback(
      [arguments, &chosen] { chosen = [arguments] { return register_clouds(*arguments); }; });
}

void add_certify(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<RegisterArguments>();
  auto& command = *program.add_subcommand(
      "certify", "Prove that a pose has the least sum of squared residuals, or bound its excess");
  command
      .add_option("pose", arguments->pose,
                  "T_target_source: 16 numbers, row-major, or a file of them")
      ->required();
  add_shared_options(command, *arguments);
  command
      .add_option("--noise-bound", arguments->noise_bound,
                  "judge by the correspondences within this distance alone, m")
      ->option_text("M");
  command.footer(
      "Exits with 4 unless the pose is certified.\n\n"
      "Examples:\n"
      "  palpate certify 1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1 --correspondences pairs.csv\n"
      "  palpate certify pose.txt --correspondences pairs.csv --noise-bound 0.004 --json");
  command.callback([arguments, &chosen] { chosen = [arguments] { return certify(*arguments); }; });
}

}  // namespace palpate::app
