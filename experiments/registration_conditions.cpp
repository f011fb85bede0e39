// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "registration/problems.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;
using geometry::PointCloud;

constexpr double kRight = 0.005;  // m, mean distance between where two poses put points
constexpr double kAsWell = 1.25;  // times the mean gap at the truth

struct Shape {
  std::string name;
  geometry::TriangleMesh mesh;
};

/// What the target's scanner sees.
enum class View { kWhole, kPart, kSide };

struct Condition {
  std::string name;
  View view = View::kWhole;
  double share = 1;     ///< of kPart
  double noise = 3e-4;  ///< m an axis
  std::size_t source_points = 6000, target_points = 8000;
  double unit = 1;       ///< of both clouds, in m
  bool scale = false;    ///< the source is of unknown scale
  bool normals = false;  ///< of the mesh, given with the points
};

std::vector<Condition> conditions() {
  return {{.name = "whole"},
          {.name = "whole, normals given", .normals = true},
          {.name = "whole, 1 mm of noise", .noise = 1e-3},
          {.name = "whole, 2 mm of noise", .noise = 2e-3},
          {.name = "whole, millimetres", .unit = 1e-3},
          {.name = "1500 points in 40 000", .source_points = 1500, .target_points = 40000},
          {.name = "60 %", .view = View::kPart, .share = 0.6},
          {.name = "40 %", .view = View::kPart, .share = 0.4},
          {.name = "25 %", .view = View::kPart, .share = 0.25},
          {.name = "seen from one side", .view = View::kSide, .target_points = 30000},
          {.name = "one side, 1 mm", .view = View::kSide, .noise = 1e-3, .target_points = 30000},
          {.name = "unknown scale", .scale = true},
          {.name = "unknown scale, 60 %", .view = View::kPart, .share = 0.6, .scale = true}};
}

PointCloud sampled(const geometry::TriangleMesh& mesh, std::size_t points, double noise,
                   bool normals, const RandomStream& random) {
  PointCloud cloud;
  RandomStream error = random.fork("noise");
  for (const auto& s : geometry::sample_surface(mesh, points, random.fork("points"))) {
    cloud.points.push_back(s.point + noise * error.normal3());
    if (normals) cloud.normals.push_back(s.normal);
  }
  return cloud;
}

/// The share of a cloud that lies farthest along a direction.
PointCloud part_of(const PointCloud& cloud, double share, const Eigen::Vector3d& direction) {
  std::vector<std::pair<double, int>> heights;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    heights.emplace_back(-direction.dot(cloud.points[i]), static_cast<int>(i));
  }
  std::ranges::sort(heights);
  std::vector<int> kept;
  const double count = share * static_cast<double>(heights.size());
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    kept.push_back(heights[i].second);
  }
  return geometry::subset(cloud, kept);
}

/// What is seen along a direction from far away: of each square the points that are nearest.
PointCloud side_of(const PointCloud& cloud, const Eigen::Vector3d& direction) {
  constexpr double kSquare = 0.0015, kThick = 0.003;  // m
  const Eigen::Matrix3d frame = frame_with_z(direction);
  std::map<std::pair<long, long>, double> nearest;
  const auto square_of = [&](const Eigen::Vector3d& p) {
    return std::pair(std::lround(frame.col(0).dot(p) / kSquare),
                     std::lround(frame.col(1).dot(p) / kSquare));
  };
  for (const auto& p : cloud.points) {
    const auto [at, first] = nearest.emplace(square_of(p), direction.dot(p));
    if (!first) at->second = std::max(at->second, direction.dot(p));
  }
  std::vector<int> kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto& p = cloud.points[i];
    if (direction.dot(p) > nearest[square_of(p)] - kThick) kept.push_back(static_cast<int>(i));
  }
  return geometry::subset(cloud, kept);
}

PointCloud scaled(PointCloud cloud, double factor) {
  for (auto& p : cloud.points) p *= factor;
  return cloud;
}

/// Two clouds and what relates them.
struct Problem {
  PointCloud source, target;
  Eigen::Isometry3d truth;  ///< T_target_source, m
  double scale = 1;         ///< of the source, times which it is as large as the target
};

Problem problem_of(const Shape& shape, const Condition& condition, const RandomStream& random) {
  RandomStream draw = random.fork("draw");
  Problem problem;
  problem.truth = testing::random_pose(draw);
  const Eigen::Vector3d direction = draw.unit_vector();
  if (condition.scale) problem.scale = std::exp(draw.uniform(std::log(0.001), std::log(1000.0)));
  PointCloud target = sampled(shape.mesh, condition.target_points, condition.noise,
                              condition.normals, random.fork("target"));
  if (condition.view == View::kPart) target = part_of(target, condition.share, direction);
  if (condition.view == View::kSide) target = side_of(target, direction);
  target = geometry::transformed(problem.truth, std::move(target));
  const PointCloud source = sampled(shape.mesh, condition.source_points, condition.noise,
                                    condition.normals, random.fork("source"));
  problem.source = scaled(source, 1 / condition.unit / problem.scale);
  problem.target = scaled(target, 1 / condition.unit);
  return problem;
}

/// Mean distance from points of the target to the nearest of the source, a gap of the answer.
double mean_gap(const PointCloud& target, const PointCloud& placed) {
  const geometry::KdTree tree(placed.points);
  double sum = 0;
  for (const auto& p : target.points) sum += std::sqrt(tree.nearest(p, 1)[0].squared_distance);
  return sum / static_cast<double>(target.size());
}

/// What came of one problem, in units of metres.
struct Answer {
  double off = 0;  ///< mean distance of where the answer and the truth put the source's points
  double gap = 0, best_gap = 0;  ///< mean_gap() of the answer, and of the truth
};

Answer answer_of(const Problem& problem, const Condition& condition,
                 const RegistrationResult& result) {
  Eigen::Isometry3d truth = problem.truth;
  truth.translation() /= condition.unit;
  const PointCloud ideal = geometry::transformed(truth, scaled(problem.source, problem.scale));
  const PointCloud placed =
      geometry::transformed(*result.T_target_source, scaled(problem.source, result.scale));
  Answer answer;
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    answer.off += (placed.points[i] - ideal.points[i]).norm() * condition.unit;
  }
  answer.off /= static_cast<double>(ideal.size());
  answer.gap = condition.unit * mean_gap(problem.target, placed);
  answer.best_gap = condition.unit * mean_gap(problem.target, ideal);
  return answer;
}

struct Counts {
  std::size_t runs = 0, right = 0, as_well = 0, wrong = 0, none = 0, degenerate = 0, mirrored = 0;

  void add(const Shape& shape, const Condition& condition, std::uint64_t seed) {
    const Problem problem = problem_of(shape, condition, RandomStream(seed, "conditions"));
    CloudOptions options;
    options.registration.estimate_scale = condition.scale;
    const auto found = register_clouds(problem.source, problem.target, options);
    const auto& result = found.result;
    ++runs;
    degenerate += result.status == RegistrationStatus::kDegenerate;
    none += result.status == RegistrationStatus::kNoConsensus && !result.mirrored;
    mirrored += result.mirrored;
    if (!result.T_target_source) return;
    const Answer answer = answer_of(problem, condition, result);
    const bool is_right = answer.off < kRight, fits = answer.gap < kAsWell * answer.best_gap;
    ++(is_right ? right : fits ? as_well : wrong);
    if (is_right || fits) return;
    fmt::print(stderr,
               "{}, {}, seed {}: {:.1f} mm off, gap {:.2f} of the truth's, {:.1e} false "
               "alarms\n",
               shape.name, condition.name, seed, 1e3 * answer.off, answer.gap / answer.best_gap,
               result.false_alarms);
  }
};

std::vector<Shape> built_in_shapes() {
  std::vector<Shape> shapes;
  for (const auto& name : geometry::built_in_objects()) {
    shapes.push_back({name, geometry::load_known_object(name).mesh});
  }
  return shapes;
}

/// Meshes of PALPATE_DATA/ycb, none without it.
std::vector<Shape> scans() {
  std::vector<Shape> shapes;
  if (const char* data = std::getenv("PALPATE_DATA")) {
    for (const auto& entry : std::filesystem::directory_iterator(std::string(data) + "/ycb")) {
      if (entry.path().extension() != ".ply") continue;
      shapes.push_back({entry.path().stem().string(), geometry::load_mesh(entry.path())});
    }
  }
  std::ranges::sort(shapes, {}, &Shape::name);
  return shapes;
}

std::vector<Shape> generated_shapes(std::uint64_t seed, std::uint64_t count) {
  std::vector<Shape> shapes;
  for (std::uint64_t k = 0; k < count; ++k) {
    shapes.push_back({fmt::format("generated:{}", seed + k), geometry::generated_shape(seed + k)});
  }
  return shapes;
}

void conditions_of(const experiment::Options& options, const std::string& title,
                   const std::string& name, const std::vector<Shape>& shapes, std::uint64_t times) {
  Table table({"target", "runs", "right", "another pose that fits as well", "wrong", "none",
               "degenerate", "mirrored"});
  for (const auto& condition : conditions()) {
    if (options.quick && condition.name != "whole") continue;
    Counts counts;
    for (std::uint64_t k = 0; k < times * shapes.size(); ++k) {
      counts.add(shapes[k % shapes.size()], condition, options.seed + k);
    }
    table.add_row({condition.name, fmt::format("{}", counts.runs), fmt::format("{}", counts.right),
                   fmt::format("{}", counts.as_well), fmt::format("{}", counts.wrong),
                   fmt::format("{}", counts.none), fmt::format("{}", counts.degenerate),
                   fmt::format("{}", counts.mirrored)});
  }
  table.publish(options, name, title);
}

void experiment_conditions(const experiment::Options& options) {
  conditions_of(options, "Generated shapes", "generated",
                generated_shapes(options.seed, options.quick ? 1 : 40), 1);
  if (options.quick) return;
  conditions_of(options, "Built-in objects", "built_in", built_in_shapes(), 6);
  const auto scanned = scans();
  if (!scanned.empty()) conditions_of(options, "Scans", "scans", scanned, 6);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "registration_conditions",
                         "Clouds of shapes seen whole, in part and from one side, with noise, in "
                         "other units and of unknown scale.",
                         experiment_conditions);
}
