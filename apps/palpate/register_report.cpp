// SPDX-License-Identifier: Apache-2.0
#include "register_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::app {
namespace {

namespace rg = registration;

nlohmann::json rows_json(const Matrix6d& matrix) {
  auto rows = nlohmann::json::array();
  for (int i = 0; i < 6; ++i) {
    auto row = nlohmann::json::array();
    for (int j = 0; j < 6; ++j) row.push_back(matrix(i, j));
    rows.push_back(row);
  }
  return rows;
}

std::string pose_text(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d w = log_so3(T.linear()) * 180 / std::numbers::pi, t = T.translation();
  return fmt::format(
      "rotation ({:.3f}, {:.3f}, {:.3f}) deg, translation ({:.6g}, {:.6g}, {:.6g}) m", w[0], w[1],
      w[2], t[0], t[1], t[2]);
}

}  // namespace

nlohmann::json report_of(const rg::RegistrationResult& result) {
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

void print_report(const rg::RegistrationResult& result) {
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

std::string correspondences_csv(const rg::Correspondences& c,
                                const rg::RegistrationResult& result) {
  const bool normals = c.has_normals();
  std::string text = "sx,sy,sz,tx,ty,tz";
  if (normals) text += ",snx,sny,snz,tnx,tny,tnz";
  text += ",weight,residual\n";
  const auto append = [&](const Eigen::Vector3d& p) {
    text += fmt::format("{},{},{},", p[0], p[1], p[2]);
  };
  for (std::size_t i = 0; i < c.size(); ++i) {
    append(c.source[i]);
    append(c.target[i]);
    if (normals) append(c.source_normals[i]);
    if (normals) append(c.target_normals[i]);
    const double residual = i < result.residuals.size() ? result.residuals[i] : std::nan("");
    text += fmt::format("{},{}\n", result.weights[i], residual);
  }
  return text;
}

std::string weight_history_csv(const std::vector<rg::GncIteration>& history) {
  std::string text = "mu,cost";
  for (std::size_t i = 0; i < history.front().weights.size(); ++i) text += fmt::format(",w{}", i);
  text += "\n";
  for (const auto& [mu, cost, weights] : history) {
    text += fmt::format("{},{},{}\n", mu, cost, fmt::join(weights, ","));
  }
  return text;
}

}  // namespace palpate::app
