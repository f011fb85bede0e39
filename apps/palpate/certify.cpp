// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "common.hpp"
#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/registration/correspondences_io.hpp"
#include "palpate/registration/pose.hpp"
#include "terminal.hpp"
#include "units_hint.hpp"

namespace palpate::app {
namespace {

namespace rg = registration;

struct CertifyArguments {
  CommonOptions common;
  std::string pose, correspondences, primitive = "point";
  std::optional<double> noise_bound;
};

constexpr std::size_t kMinPairs = 3;  // that determine a pose

/// The correspondences within the bound, m.
rg::Correspondences inliers_of(const rg::Correspondences& correspondences,
                               const Eigen::Isometry3d& T, double bound) {
  const auto squared = rg::squared_residuals(correspondences, T, rg::Primitive::kPoint);
  std::vector<int> inliers;
  for (std::size_t i = 0; i < squared.size(); ++i) {
    if (std::sqrt(squared[i]) <= bound) inliers.push_back(static_cast<int>(i));
  }
  return rg::subset(correspondences, inliers);
}

/// What may be the reason that a pose is not certified, if not the unit of the points.
std::string reason_of(const CertifyArguments& arguments, std::size_t pairs) {
  if (!arguments.noise_bound) {
    return fmt::format("all {} pairs count; if there are outliers among them, use --noise-bound",
                       pairs);
  }
  const double bound = *arguments.noise_bound;
  if (pairs == 0) {
    return fmt::format("no pair is within {:g} m of this pose; nothing to certify", bound);
  }
  if (pairs >= kMinPairs) return "";
  return fmt::format("only {} of the pairs {} within {:g} m of this pose; three are the least",
                     pairs, pairs == 1 ? "is" : "are", bound);
}

void print_result(const rg::PoseEstimate& estimate, std::size_t pairs) {
  fmt::print("{}: cost {:.6g} m^2 of {} correspondences",
             colored_status(rg::to_string(estimate.status)), estimate.cost, pairs);
  if (pairs >= kMinPairs) {
    fmt::print(", at most {:.2g} m^2 above the global optimum", estimate.bound);
  }
  fmt::print("\n");
}

int certify(const CertifyArguments& arguments) {
  const Eigen::Isometry3d T = parse_pose(arguments.pose);
  const auto primitive =
      arguments.primitive == "plane" ? rg::Primitive::kPlane : rg::Primitive::kPoint;
  auto correspondences = rg::read_correspondences(arguments.correspondences);
  std::string hint =
      units_hint(correspondences.source, correspondences.target, arguments.noise_bound.value_or(0));
  const auto start = std::chrono::steady_clock::now();
  if (arguments.noise_bound) {
    correspondences = inliers_of(correspondences, T, *arguments.noise_bound);
  }
  if (hint.empty()) hint = reason_of(arguments, correspondences.size());
  const auto estimate = rg::certify(T, correspondences, {}, primitive);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  const bool certified = estimate.status == rg::Status::kCertified;
  const nlohmann::json report = {{"status", rg::to_string(estimate.status)},
                                 {"cost", estimate.cost},
                                 {"bound", estimate.bound},
                                 {"reference", estimate.reference},
                                 {"correspondences", correspondences.size()},
                                 {"information_rank", estimate.rank},
                                 {"hint", certified ? "" : hint},
                                 {"seconds", elapsed.count()}};
  if (!arguments.common.out.empty()) {
    const std::filesystem::path folder = arguments.common.out;
    const auto output = claim_output(arguments.common, {"report.json"});
    write_file_atomically(folder / "report.json", json_text(report));
  }
  if (arguments.common.json) {
    print_json(report);
  } else {
    print_result(estimate, correspondences.size());
    if (!certified && !hint.empty()) fmt::print("{}\n", hint);
    if (estimate.status == rg::Status::kUncertified) {
      print_next(arguments.common,
                 fmt::format("palpate register --correspondences {} finds the pose that most pairs "
                             "agree with",
                             quoted(arguments.correspondences)));
    }
  }
  return certified ? kDone : kNoSolution;
}

}  // namespace

void add_certify(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<CertifyArguments>();
  auto& command = *program.add_subcommand(
      "certify", "Certify that a pose minimises the sum of squared residuals, or bound its excess");
  command
      .add_option("pose", arguments->pose,
                  "T_target_source: 16 numbers, row-major, or a file of them")
      ->required();
  command
      .add_option("--correspondences", arguments->correspondences,
                  "CSV with sx,sy,sz,tx,ty,tz[,snx,sny,snz,tnx,tny,tnz] in metres")
      ->option_text("FILE")
      ->required();
  command
      .add_option("--primitive", arguments->primitive,
                  "residuals: distances of points (point) or along target normals (plane)")
      ->check(CLI::IsMember({"point", "plane"}))
      ->capture_default_str();
  add_common_options(command, arguments->common, kOut);
  command
      .add_option("--noise-bound", arguments->noise_bound,
                  "use only the correspondences within this distance, m")
      ->option_text("M")
      ->check(positive());
  command.footer(
      "Exits with 4 unless the pose is certified. --out receives report.json.\n\n"
      "Examples:\n"
      "  palpate certify pose.txt --correspondences pairs.csv --noise-bound 0.004\n"
      "  palpate certify 1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1 --correspondences inliers.csv --json");
  command.callback([arguments, &chosen] { chosen = [arguments] { return certify(*arguments); }; });
}

}  // namespace palpate::app
