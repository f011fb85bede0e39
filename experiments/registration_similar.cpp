// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;
using geometry::PointCloud;

constexpr double kRight = 0.005;  // m, mean distance between where two poses put points

PointCloud sampled(const geometry::TriangleMesh& mesh, const RandomStream& random) {
  constexpr std::size_t kPoints = 6000;
  constexpr double kNoise = 3e-4;  // m an axis
  PointCloud cloud;
  RandomStream noise = random.fork("noise");
  for (const auto& s : geometry::sample_surface(mesh, kPoints, random.fork("points"))) {
    cloud.points.push_back(s.point + kNoise * noise.normal3());
  }
  return cloud;
}

/// The share of a cloud that lies farthest along a direction.
PointCloud part_of(const PointCloud& cloud, double share, const Eigen::Vector3d& direction) {
  std::vector<std::pair<double, int>> heights;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    heights.emplace_back(direction.dot(cloud.points[i]), static_cast<int>(i));
  }
  std::ranges::sort(heights);
  std::vector<int> kept;
  for (std::size_t i = 0; i < static_cast<std::size_t>(share * static_cast<double>(heights.size()));
       ++i) {
    kept.push_back(heights[i].second);
  }
  return geometry::subset(cloud, kept);
}

/// Mean distance between where a pose at a scale and the truth put the points.
double mean_distance(const PointCloud& cloud, const Eigen::Isometry3d& T, double scale,
                     const Eigen::Isometry3d& truth) {
  double sum = 0;
  for (const auto& p : cloud.points) sum += (T * (scale * p) - truth * p).norm();
  return sum / static_cast<double>(cloud.size());
}

void unknown_scale(const experiment::Options& options) {
  Table table({"of the target", "runs", "right", "wrong", "none", "degenerate",
               "median error of the scale, %", "largest"});
  for (const double share : {1.0, 0.6}) {
    std::size_t right = 0, wrong = 0, none = 0, degenerate = 0;
    std::vector<double> errors;
    const std::uint64_t runs = options.quick ? 1 : 40;
    for (std::uint64_t seed = options.seed; seed < options.seed + runs; ++seed) {
      const RandomStream random(seed, "unknown scale");
      RandomStream pose = random.fork("pose");
      const auto mesh = geometry::generated_shape(seed);
      const PointCloud source = sampled(mesh, random.fork("source"));
      const Eigen::Isometry3d truth = testing::random_pose(pose);
      const double scale = std::exp(pose.uniform(std::log(0.001), std::log(1000.0)));
      const PointCloud target = geometry::transformed(
          truth, part_of(sampled(mesh, random.fork("target")), share, pose.unit_vector()));
      PointCloud scaled = source;
      for (auto& p : scaled.points) p /= scale;
      CloudOptions cloud_options;
      cloud_options.registration.estimate_scale = true;
      const RegistrationResult found = register_clouds(scaled, target, cloud_options).result;
      degenerate += found.status == RegistrationStatus::kDegenerate;
      none += found.status == RegistrationStatus::kNoConsensus;
      if (!found.T_target_source) continue;
      const double off = mean_distance(source, *found.T_target_source, found.scale / scale, truth);
      ++(off < kRight ? right : wrong);
      if (off < kRight) errors.push_back(100 * std::abs(found.scale / scale - 1));
    }
    std::ranges::sort(errors);
    const bool any = !errors.empty();
    table.add_row({fmt::format("{:.0f} %", 100 * share), fmt::format("{}", runs),
                   fmt::format("{}", right), fmt::format("{}", wrong), fmt::format("{}", none),
                   fmt::format("{}", degenerate),
                   any ? fmt::format("{:.3f}", errors[errors.size() / 2]) : "-",
                   any ? fmt::format("{:.3f}", errors.back()) : "-"});
  }
  table.publish(options, "unknown_scale",
                "Generated shapes against themselves, the source 0.001 to 1000 times as large");
}

void several_instances(const experiment::Options& options) {
  constexpr std::size_t kCopies = 3;
  Table table({"runs", "copies", "found", "wrong or twice", "scenes degenerate"});
  std::size_t right = 0, wrong = 0, degenerate = 0;
  const std::uint64_t runs = options.quick ? 1 : 40;
  for (std::uint64_t seed = options.seed; seed < options.seed + runs; ++seed) {
    const RandomStream random(seed, "several instances");
    RandomStream pose = random.fork("pose");
    const auto mesh = geometry::generated_shape(seed);
    PointCloud scene;
    std::vector<Eigen::Isometry3d> truths;
    for (std::size_t k = 0; k < kCopies; ++k) {
      Eigen::Isometry3d T = testing::random_pose(pose, 0.02);
      T.translation().x() = 0.25 * static_cast<double>(k);
      truths.push_back(T);
      const PointCloud copy =
          geometry::transformed(T, sampled(mesh, random.fork(fmt::format("copy {}", k))));
      scene.points.insert(scene.points.end(), copy.points.begin(), copy.points.end());
    }
    CloudOptions cloud_options;
    cloud_options.registration.instances = kCopies + 1;
    const PointCloud source = sampled(mesh, random.fork("source"));
    const RegistrationResult found = register_clouds(source, scene, cloud_options).result;
    degenerate += found.status == RegistrationStatus::kDegenerate;
    if (!found.T_target_source) continue;
    std::vector<Eigen::Isometry3d> answers = {*found.T_target_source};
    for (const auto& other : found.instances) answers.push_back(other.T_target_source);
    for (const auto& T : answers) {
      const auto removed = std::erase_if(truths, [&](const Eigen::Isometry3d& truth) {
        return mean_distance(source, T, 1, truth) < kRight;
      });
      removed > 0 ? ++right : ++wrong;
    }
  }
  table.add_row({fmt::format("{}", runs), fmt::format("{}", kCopies * runs),
                 fmt::format("{}", right), fmt::format("{}", wrong),
                 fmt::format("{}", degenerate)});
  table.publish(options, "several_instances",
                "Scenes of three copies of a generated shape, of which four are asked for");
}

void experiment_similar(const experiment::Options& options) {
  unknown_scale(options);
  several_instances(options);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_similar",
                         "Clouds of unknown scale, and several instances of one.",
                         experiment_similar);
}
