// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;
using geometry::PointCloud;

constexpr std::size_t kPoints = 6000;
constexpr double kNoise = 3e-4;  // m an axis

PointCloud sampled(const geometry::TriangleMesh& mesh, const RandomStream& random) {
  PointCloud cloud;
  RandomStream noise = random.fork("noise");
  for (const auto& s : geometry::sample_surface(mesh, kPoints, random.fork("points"))) {
    cloud.points.push_back(s.point + kNoise * noise.normal3());
  }
  return cloud;
}

PointCloud moved(PointCloud cloud, RandomStream random, Eigen::Isometry3d& T_target_source) {
  T_target_source = testing::random_pose(random);
  return geometry::transformed(T_target_source.inverse(), std::move(cloud));
}

/// Poses of feature matches alone, without what register_clouds() knows of features.
bool is_found_by_matches(const PointCloud& source, const PointCloud& target, bool normals) {
  const double voxel = suggested_voxel(source, target, FeatureOptions{}.max_points);
  const FeatureCloud from = describe(source, voxel), to = describe(target, voxel);
  Correspondences pairs;
  for (const auto& match : geometry::mutual_matches(from.features, to.features)) {
    const auto i = static_cast<std::size_t>(match.source),
               j = static_cast<std::size_t>(match.target);
    pairs.source.push_back(from.cloud.points[i]);
    pairs.target.push_back(to.cloud.points[j]);
    pairs.source_normals.push_back(from.cloud.normals[i]);
    pairs.target_normals.push_back(to.cloud.normals[j]);
  }
  const auto result = register_correspondences(
      pairs, {.noise_bound = 1.5 * voxel, .normal_noise_deg = normals ? 10.0 : 0.0});
  return result.T_target_source.has_value();
}

struct Counts {
  std::size_t clouds = 0, matches = 0, matches_with_normals = 0, runs = 0;

  void add(const PointCloud& source, const PointCloud& target) {
    ++runs;
    clouds += register_clouds(source, target).result.T_target_source.has_value();
    matches += is_found_by_matches(source, target, false);
    matches_with_normals += is_found_by_matches(source, target, true);
  }
};

std::string share(std::size_t count, std::size_t all) {
  const Interval interval = wilson_interval(count, all);
  return fmt::format("{} ({:.3f}..{:.3f})", count, interval.low, interval.high);
}

/// Meshes of PALPATE_DATA/ycb, none without it.
std::vector<geometry::TriangleMesh> scans() {
  std::vector<std::filesystem::path> files;
  if (const char* data = std::getenv("PALPATE_DATA")) {
    for (const auto& entry : std::filesystem::directory_iterator(std::string(data) + "/ycb")) {
      if (entry.path().extension() == ".ply") files.push_back(entry.path());
    }
  }
  std::ranges::sort(files);
  std::vector<geometry::TriangleMesh> meshes;
  for (const auto& file : files) meshes.push_back(geometry::load_mesh(file));
  return meshes;
}

void different_objects(const experiment::Options& options) {
  Table table({"pairs of", "runs", "clouds: a pose", "feature matches: a pose",
               "feature matches with normals: a pose"});
  const auto add = [&](const std::string& name, const Counts& counts) {
    table.add_row({name, fmt::format("{}", counts.runs), share(counts.clouds, counts.runs),
                   share(counts.matches, counts.runs),
                   share(counts.matches_with_normals, counts.runs)});
  };
  Eigen::Isometry3d T;
  Counts generated;
  for (std::uint64_t k = 0; k < (options.quick ? 1u : 250u); ++k) {
    const std::uint64_t seed = options.seed + 2 * k;
    const RandomStream random(seed, "different objects");
    const PointCloud target = sampled(geometry::generated_shape(seed), random.fork("target"));
    const PointCloud source = sampled(geometry::generated_shape(seed + 1), random.fork("source"));
    generated.add(moved(source, random.fork("pose"), T), target);
  }
  add("generated shapes", generated);
  Counts scanned;
  const auto meshes = options.quick ? std::vector<geometry::TriangleMesh>{} : scans();
  for (std::size_t a = 0; a < meshes.size(); ++a) {
    for (std::size_t b = 0; b < meshes.size(); ++b) {
      if (a == b) continue;
      const RandomStream random(options.seed + 10 * a + b, "different scans");
      scanned.add(moved(sampled(meshes[a], random.fork("source")), random.fork("pose"), T),
                  sampled(meshes[b], random.fork("target")));
    }
  }
  if (scanned.runs > 0) add("scans", scanned);
  table.publish(options, "different_objects", "Clouds of two different objects: no pose is right");
}

/// Mean distance from the moved source's points to the nearest of the target.
double mean_gap(const PointCloud& source, const Eigen::Isometry3d& T, const PointCloud& target) {
  const geometry::KdTree tree(target.points);
  double sum = 0;
  for (const auto& p : source.points) sum += std::sqrt(tree.nearest(T * p, 1)[0].squared_distance);
  return sum / static_cast<double>(source.size());
}

/// Mean distance between the places where two poses put points.
double mean_distance(const PointCloud& cloud, const Eigen::Isometry3d& a,
                     const Eigen::Isometry3d& b) {
  double sum = 0;
  for (const auto& p : cloud.points) sum += (a * p - b * p).norm();
  return sum / static_cast<double>(cloud.size());
}

void same_objects(const experiment::Options& options) {
  Table table({"source", "runs", "right", "another pose", "that fits as well", "none", "degenerate",
               "flagged as mirrored"});
  for (const bool mirrored : {false, true}) {
    std::size_t right = 0, wrong = 0, none = 0, degenerate = 0, flagged = 0, fits = 0;
    const std::uint64_t runs = options.quick ? 1 : 40;
    for (std::uint64_t k = 0; k < runs; ++k) {
      const RandomStream random(options.seed + k, "same object");
      const auto mesh = geometry::generated_shape(options.seed + k);
      Eigen::Isometry3d truth;
      PointCloud source = moved(sampled(mesh, random.fork("source")), random.fork("pose"), truth);
      const PointCloud target = sampled(mesh, random.fork("target"));
      const double gap = mean_gap(source, truth, target);
      for (auto& p : source.points) p.x() *= mirrored ? -1 : 1;
      const auto found = register_clouds(source, target);
      flagged += found.result.mirrored;
      degenerate += found.result.status == RegistrationStatus::kDegenerate;
      none += found.result.status == RegistrationStatus::kNoConsensus;
      if (!found.result.T_target_source) continue;
      const bool near = mean_distance(source, *found.result.T_target_source, truth) < 0.005;
      ++(near && !mirrored ? right : wrong);
      if (near && !mirrored) continue;
      fits += mean_gap(source, *found.result.T_target_source, target) < 1.25 * gap;
    }
    table.add_row({mirrored ? "mirrored" : "the same object", fmt::format("{}", runs),
                   fmt::format("{}", right), fmt::format("{}", wrong), fmt::format("{}", fits),
                   fmt::format("{}", none), fmt::format("{}", degenerate),
                   fmt::format("{}", flagged)});
  }
  table.publish(options, "same_objects",
                "Generated shapes held against another sample of themselves, and mirrored");
}

/// A surface that slides along itself, of unit size.
struct Surface {
  std::string name;
  std::size_t free;  // motions
  std::function<Eigen::Vector3d(RandomStream&)> point;
};

std::vector<Surface> sliding_surfaces() {
  const auto turn = [](RandomStream& r) { return r.uniform(0, 2 * std::numbers::pi); };
  return {
      {"sphere", 3, [](RandomStream& r) { return r.unit_vector(); }},
      {"cylinder", 2,
       [turn](RandomStream& r) {
         const double a = turn(r);
         return Eigen::Vector3d(0.5 * std::cos(a), 0.5 * std::sin(a), r.uniform(-1, 1));
       }},
      {"cone", 1,
       [turn](RandomStream& r) {
         const double a = turn(r), h = std::sqrt(r.uniform(0.04, 1.0));
         return Eigen::Vector3d(0.7 * h * std::cos(a), 0.7 * h * std::sin(a), h);
       }},
      {"torus", 1,
       [turn](RandomStream& r) {
         const double a = turn(r), b = turn(r), d = 1 + 0.35 * std::cos(b);
         return Eigen::Vector3d(d * std::cos(a), d * std::sin(a), 0.35 * std::sin(b));
       }},
      {"plate", 3,
       [](RandomStream& r) { return Eigen::Vector3d(r.uniform(-1, 1), r.uniform(-0.7, 0.7), 0); }},
  };
}

void free_motions_of_surfaces(const experiment::Options& options) {
  Table table({"surface", "noise mm", "runs", "degenerate", "all motions named", "a pose"});
  for (const auto& surface : sliding_surfaces()) {
    for (const double noise : {0.0, 3e-4}) {
      std::size_t degenerate = 0, named = 0, poses = 0;
      const std::uint64_t runs = options.quick ? 1 : 15;
      for (std::uint64_t k = 0; k < runs; ++k) {
        RandomStream random(options.seed + k, "sliding " + surface.name);
        PointCloud clouds[2];
        const double size = random.uniform(0.03, 0.12);
        for (auto& cloud : clouds) {
          for (std::size_t i = 0; i < kPoints; ++i) {
            cloud.points.push_back(size * surface.point(random) + noise * random.normal3());
          }
        }
        Eigen::Isometry3d T;
        const auto result =
            register_clouds(moved(clouds[0], random.fork("pose"), T), clouds[1]).result;
        degenerate += result.status == RegistrationStatus::kDegenerate;
        named += result.free_motions.size() == surface.free;
        poses += result.T_target_source.has_value();
      }
      table.add_row({surface.name, fmt::format("{}", 1e3 * noise), fmt::format("{}", runs),
                     fmt::format("{}", degenerate), fmt::format("{}", named),
                     fmt::format("{}", poses)});
    }
  }
  table.publish(options, "sliding", "Surfaces that slide along themselves");
}

void experiment_clouds(const experiment::Options& options) {
  free_motions_of_surfaces(options);
  different_objects(options);
  same_objects(options);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_clouds",
                         "Clouds of different objects, mirrored ones, and surfaces that slide "
                         "along themselves.",
                         experiment_clouds);
}
