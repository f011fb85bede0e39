// SPDX-License-Identifier: Apache-2.0
#include "localize_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common.hpp"
#include "localize_evidence.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/se3.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace lo = localization;

constexpr std::size_t kMaxShown = 10;  // modes
constexpr double kCertain = 0.95;      // probability, as of the search's own status

/// Of the mesh's pose in the contacts' frame.
Matrix6d mesh_covariance(const lo::Mode& mode, const Eigen::Isometry3d& T_object_mesh) {
  return covariance_at(mode.T_frame_object.linear() * T_object_mesh.translation(), mode.covariance);
}

/// That the object is where the mode says, turns about the mode's free axis aside if asked.
double probability_of(const lo::Mode& mode, bool ignore_spin) {
  return ignore_spin ? mode.weight : lo::pose_probability(mode);
}

/// As the posterior's own, or where spin does not matter by the best mode's weight.
std::string_view status_of(const lo::Posterior& posterior, bool ignore_spin) {
  if (!ignore_spin || posterior.modes.empty()) return lo::to_string(posterior.status);
  const bool certain = posterior.modes.front().weight > kCertain;
  return lo::to_string(certain ? lo::PoseStatus::certain : lo::PoseStatus::ambiguous);
}

double best_probability(const lo::Posterior& posterior, bool ignore_spin) {
  if (posterior.modes.empty()) return 0;
  return probability_of(posterior.modes.front(), ignore_spin);
}

std::vector<double> row_major(const Matrix6d& matrix) {
  std::vector<double> values;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) values.push_back(matrix(i, j));
  }
  return values;
}

std::array<double, 3> triple(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

nlohmann::json axis_json(const lo::Mode& mode) {
  if (!mode.free_axis) return nullptr;
  return {{"point", triple(mode.free_axis->point)},
          {"direction", triple(mode.free_axis->direction)},
          {"extent", mode.free_axis->extent}};
}

void print_mode(const lo::Mode& mode, const Eigen::Isometry3d& T_object_mesh, bool ignore_spin) {
  const Eigen::Isometry3d T = mode.T_frame_object * T_object_mesh;
  const Eigen::Vector3d w = log_so3(T.linear()) / kDegree, t = 1e3 * T.translation();
  const Matrix6d covariance = mesh_covariance(mode, T_object_mesh);
  fmt::print(
      "{:6.3f}  ({:7.1f}, {:7.1f}, {:7.1f}) deg  ({:7.1f}, {:7.1f}, {:7.1f}) mm  +- {:.1f} deg, "
      "{:.1f} mm",
      probability_of(mode, ignore_spin), w[0], w[1], w[2], t[0], t[1], t[2],
      std::sqrt(covariance.topLeftCorner<3, 3>().trace()) / kDegree,
      1e3 * std::sqrt(covariance.bottomRightCorner<3, 3>().trace()));
  if (mode.free_axis) {
    const auto& axis = *mode.free_axis;
    fmt::print("  free by +- {:.0f} deg about ({:.2f}, {:.2f}, {:.2f})", axis.extent / kDegree,
               axis.direction[0], axis.direction[1], axis.direction[2]);
  }
  fmt::print("\n");
}

}  // namespace

nlohmann::json report_of(const LocalizeResult& result) {
  auto modes = nlohmann::json::array();
  for (const lo::Mode& mode : result.posterior.modes) {
    modes.push_back({{"T_contact_object", to_json(mode.T_frame_object * result.T_object_mesh)},
                     {"weight", mode.weight},
                     {"probability", probability_of(mode, result.ignore_spin)},
                     {"covariance", row_major(mesh_covariance(mode, result.T_object_mesh))},
                     {"free_axis", axis_json(mode)}});
  }
  auto residual_set = nlohmann::json::array();
  for (const auto& T : result.posterior.residual_set)
    residual_set.push_back(to_json(T * result.T_object_mesh));
  auto objects = nlohmann::json::array();
  for (std::size_t i = 0; i < result.names.size(); ++i) {
    objects.push_back({{"name", result.names[i]}, {"probability", result.objects.candidates[i]}});
  }
  return {{"status", status_of(result.posterior, result.ignore_spin)},
          {"object", result.names[result.objects.best]},
          {"objects", objects},
          {"other_object", result.objects.other},
          {"size", result.objects.size},
          {"probability", best_probability(result.posterior, result.ignore_spin)},
          {"modes", modes},
          {"residual_mass", result.posterior.residual_mass()},
          {"residual_set", residual_set},
          {"credible_mass", result.posterior.credible_mass},
          {"method", result.method},
          {"hint", result.hint},
          {"repairs", result.repairs},
          {"prepare_seconds", result.prepare_seconds},
          {"seconds", result.posterior.seconds}};
}

void print_result(const LocalizeResult& result) {
  fmt::print("{}: {} mode{} in {:.0f} ms, after {:.2f} s of preparation\n",
             colored_status(status_of(result.posterior, result.ignore_spin)),
             result.posterior.modes.size(), result.posterior.modes.size() == 1 ? "" : "s",
             1e3 * result.posterior.seconds, result.prepare_seconds);
  for (std::size_t i = 0; result.names.size() > 1 && i < result.names.size(); ++i) {
    fmt::print("{:6.3f}  {}\n", result.objects.candidates[i], result.names[i]);
  }
  if (result.names.size() > 1) fmt::print("{:6.3f}  another object\n", result.objects.other);
  if (result.objects.size != 1) {
    fmt::print("{:.3f} times the size of its mesh\n", result.objects.size);
  }
  for (const auto& repair : result.repairs) fmt::print("mesh repaired: {}\n", repair);
  if (!result.hint.empty()) fmt::print("{}\n", result.hint);
  if (result.posterior.modes.empty()) return;
  fmt::print("{:<6}  {:<31}  {:<30}  standard deviations\n", "prob.", "rotation vector",
             "translation");
  const auto& modes = result.posterior.modes;
  const std::size_t shown = std::min(kMaxShown, modes.size());
  for (std::size_t i = 0; i < shown; ++i) {
    print_mode(modes[i], result.T_object_mesh, result.ignore_spin);
  }
  if (shown < modes.size()) {
    double rest = 0;
    for (std::size_t i = shown; i < modes.size(); ++i) rest += modes[i].weight;
    fmt::print("{:6.3f}  in {} more (--json lists them)\n", rest, modes.size() - shown);
  }
  const std::size_t rest = result.posterior.residual_set.size();
  if (rest == 0) return;
  fmt::print("{:6.3f}  elsewhere ({} poses of it in --json)\n", result.posterior.residual_mass(),
             rest);
  if (result.posterior.credible_mass < lo::kCredible) {
    fmt::print(
        "the samples are too few for a 95 % set: modes and these poses hold some {:.0f} % or "
        "more\n",
        100 * result.posterior.credible_mass);
  }
}

}  // namespace palpate::app
