// SPDX-License-Identifier: Apache-2.0
#include "register_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"
#include "terminal.hpp"

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

/// Without what is but rounding, which would show as 1.2e-17 or -0.000.
Eigen::Vector3d rounded(const Eigen::Vector3d& v, double least) {
  return v.unaryExpr([least](double x) { return std::abs(x) < least ? 0.0 : x; });
}

std::string motion_text(const Eigen::Isometry3d& T) {
  constexpr double kMinAngle = 5e-4, kMinLength = 1e-9;  // deg, m
  const Eigen::Vector3d w = rounded(log_so3(T.linear()) * 180 / std::numbers::pi, kMinAngle);
  const Eigen::Vector3d t = rounded(T.translation(), kMinLength);
  return fmt::format(
      "rotation ({:.3f}, {:.3f}, {:.3f}) deg, translation ({:.6g}, {:.6g}, {:.6g}) m", w[0], w[1],
      w[2], t[0], t[1], t[2]);
}

nlohmann::json instance_json(const rg::RunnerUp& instance) {
  return {{"inliers", instance.inliers},
          {"T_target_source", to_json(instance.T_target_source)},
          {"false_alarms", instance.false_alarms}};
}

std::string number_of_false_alarms(double expected) {
  constexpr double kLeast = 1e-300;  // smaller ones are not exact, or 0
  if (!std::isfinite(expected)) return "any number of";
  return expected < kLeast ? fmt::format("fewer than {:g}", kLeast)
                           : fmt::format("{:.1g}", expected);
}

nlohmann::json vector_json(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

nlohmann::json motion_json(const rg::FreeMotion& motion) {
  return {{"kind", rg::to_string(motion.kind)},
          {"direction", vector_json(motion.direction)},
          {"point", vector_json(motion.point)},
          {"pitch", motion.pitch}};
}

std::string motion_text(const rg::FreeMotion& motion) {
  const Eigen::Vector3d &d = motion.direction, &p = motion.point;
  return fmt::format("{} along ({:.3f}, {:.3f}, {:.3f}) through ({:.4g}, {:.4g}, {:.4g}) m",
                     rg::to_string(motion.kind), d[0], d[1], d[2], p[0], p[1], p[2]);
}

}  // namespace

nlohmann::json report_of(const rg::RegistrationResult& result) {
  nlohmann::json pose, runner_up, robust, covariance;  // null
  if (result.T_target_source) pose = to_json(*result.T_target_source);
  if (result.T_target_source) covariance = rows_json(result.covariance);
  if (result.runner_up) runner_up = instance_json(*result.runner_up);
  if (const auto& bound = result.certificate.robust) {
    robust = {{"max_inliers", bound->max_inliers},
              {"min_cost", bound->min_cost},
              {"cost", bound->cost},
              {"exhausted", bound->is_exhausted},
              {"nodes", bound->nodes},
              {"seconds", bound->seconds}};
  }
  auto instances = nlohmann::json::array(), motions = nlohmann::json::array();
  for (const auto& instance : result.instances) instances.push_back(instance_json(instance));
  for (const auto& motion : result.free_motions) motions.push_back(motion_json(motion));
  return {{"status", rg::to_string(result.status)},
          {"T_target_source", pose},
          {"scale", result.scale},
          {"inliers", result.inliers},
          {"false_alarms", result.false_alarms},
          {"certificate",
           {{"least_squares", result.certificate.least_squares},
            {"resolution_deg", result.certificate.resolution_deg},
            {"robust_bound", robust}}},
          {"runner_up", runner_up},
          {"instances", instances},
          {"mirrored", result.mirrored},
          {"false_inliers", result.false_inliers},
          {"covariance", covariance},
          {"information_rank", result.rank},
          {"free_motions", motions},
          {"cost", result.cost},
          {"bound", result.bound},
          {"weights", result.weights},
          {"residuals", result.residuals},
          {"iterations", result.iterations},
          {"search_seconds", result.search_seconds},
          {"solve_seconds", result.solve_seconds},
          {"seconds", result.seconds}};
}

void print_report(const rg::RegistrationResult& result, const std::string& hint,
                  bool has_false_alarms) {
  const std::string status = colored_status(rg::to_string(result.status));
  const bool explained = !result.T_target_source && !hint.empty();
  if (explained) fmt::print("{}: {}\n", status, hint);
  fmt::print("{}{} of {} correspondences are inliers, {:.2f} ms\n", explained ? "" : status + ": ",
             result.inliers.size(), result.weights.size(), 1e3 * result.seconds);
  for (const auto& motion : result.free_motions) fmt::print("free {}\n", motion_text(motion));
  if (result.mirrored) fmt::print("more correspondences agree with a mirror image\n");
  if (!result.T_target_source) return;
  fmt::print("target from source: {}\n", motion_text(*result.T_target_source));
  if (result.scale != 1) fmt::print("scale of the source: {:.6g}\n", result.scale);
  fmt::print("cost {:.3g} m^2, at most {:.1g} m^2 above the global optimum for these inliers\n",
             result.cost, result.bound);
  if (has_false_alarms) {
    fmt::print("false alarms: {} such poses expected by chance\n",
               number_of_false_alarms(result.false_alarms));
  }
  for (const auto& instance : result.instances) {
    fmt::print("another instance: {} inliers, {}\n", instance.inliers,
               motion_text(instance.T_target_source));
  }
  if (result.runner_up && result.instances.empty()) {
    fmt::print("runner-up: {} other inliers, {}\n", result.runner_up->inliers,
               motion_text(result.runner_up->T_target_source));
  }
}

std::string reason_of(const rg::RegistrationResult& result,
                      const rg::RegistrationOptions& options) {
  if (result.T_target_source || result.mirrored || !result.free_motions.empty()) return "";
  if (result.status == rg::RegistrationStatus::kDegenerate) {
    return options.estimate_scale ? "an unknown scale takes at least four pairs" : "";
  }
  if (options.initial) return "no pose near the initial one agrees with more pairs than by chance";
  return options.best_effort
             ? "no three pairs agree with a pose"
             : "no pose agrees with more pairs than by chance; --best-effort reports the best one";
}

std::string reason_of(const rg::CloudRegistration& registration,
                      const rg::RegistrationOptions& options) {
  const auto& result = registration.result;
  if (result.T_target_source || result.mirrored || !result.free_motions.empty()) return "";
  if (registration.contradiction > rg::kMaxContradiction) return "";
  if (options.initial) return "the clouds do not lie on one another near the initial pose";
  if (registration.feature_matches < 3) {
    return fmt::format(
        "too few features match ({}; three are the least); --initial refines a pose without them",
        registration.feature_matches);
  }
  if (result.false_alarms < options.max_false_alarms) {
    return "the clouds do not lie on one another at the pose that their features propose";
  }
  return "no pose agrees with more feature matches than by chance; --initial refines a pose "
         "without them";
}

void print_bound(const rg::RegistrationResult& result) {
  const auto& bound = result.certificate.robust;
  if (!result.T_target_source || !bound) return;
  fmt::print("upper bound: no pose has more than {} inliers\n", bound->max_inliers);
}

void print_features(const rg::CloudRegistration& registration) {
  if (!(registration.voxel > 0)) return;
  fmt::print("{} feature matches at {:.3g} m between points, {} of them within {:.3g} m",
             registration.feature_matches, registration.voxel, registration.feature_inliers,
             registration.noise_bound);
  if (const auto& bound = registration.result.certificate.robust) {
    fmt::print(" (of no pose more than {})", bound->max_inliers);
  }
  fmt::print("; {} rounds of nearest neighbours\n", registration.refinements);
  if (registration.contradiction > rg::kMaxContradiction) {
    fmt::print("contradiction: {:.0f} % of the surfaces within reach of each other lie apart\n",
               100 * registration.contradiction);
  }
  if (!registration.result.T_target_source) return;
  fmt::print("overlap: {:.0f} % of the source, residuals of {:.2g} m\n", 100 * registration.overlap,
             registration.rms_error);
}

std::string correspondences_csv(const rg::Correspondences& c,
                                const rg::RegistrationResult& result) {
  const bool normals = c.has_normals();
  std::string text = "sx,sy,sz,tx,ty,tz";
  if (normals) text += ",snx,sny,snz,tnx,tny,tnz";
  text += ",inlier_weight,residual\n";
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
