// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"

namespace {

using namespace palpate;

/// The same surface of four times as many triangles.
geometry::TriangleMesh subdivided(const geometry::TriangleMesh& mesh) {
  geometry::TriangleMesh result{mesh.vertices, {}};
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [found, added] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(result.vertices.size()));
    if (added) {
      result.vertices.push_back(0.5 * (mesh.vertices[static_cast<std::size_t>(a)] +
                                       mesh.vertices[static_cast<std::size_t>(b)]));
    }
    return found->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const auto& t : {std::array{a, ab, ca}, std::array{b, bc, ab}, std::array{c, ca, bc},
                          std::array{ab, bc, ca}}) {
      result.triangles.push_back(t);
    }
  }
  return result;
}

/// A box, or an egg of so many corners.
geometry::RoundedHull convex_tip(int corners, RandomStream& random) {
  const Eigen::Vector3d half(0.006, 0.007, 0.012);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < corners; ++i) {
    const Eigen::Vector3d corner(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    points.emplace_back(half.cwiseProduct(corners == 8 ? corner : random.unit_vector()));
  }
  return {points, 0.001};
}

/// One fingertip against the true surface of the duck. Argument: how often each triangle is cut in
/// four.
void meet_fingertip(benchmark::State& state) {
  geometry::TriangleMesh surface = geometry::load_known_object("duck").mesh;
  for (int i = 0; i < state.range(0); ++i) surface = subdivided(surface);
  const geometry::MeshQuery mesh(std::move(surface));
  const geometry::CapsuleCollider collider(mesh);
  RandomStream random(1);
  std::vector<geometry::Capsule> capsules;
  for (int i = 0; i < 256; ++i) {
    const geometry::ClosestPoint near = mesh.closest_point(0.1 * random.unit_vector());
    const Eigen::Vector3d middle = near.point + 0.0068 * near.normal;
    const Eigen::Vector3d half = 0.009 * near.normal.cross(random.unit_vector()).normalized();
    capsules.push_back({middle - half, middle + half, 0.007});
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(collider.contacts(capsules[i++ % capsules.size()], 0, 2));
  }
  state.counters["triangles"] = static_cast<double>(mesh.mesh().triangles.size());
}
BENCHMARK(meet_fingertip)->ArgName("cuts")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond);

/// The same with a fingertip of another shape. Arguments: its corners (8: a box), cuts.
void meet_convex_fingertip(benchmark::State& state) {
  geometry::TriangleMesh surface = geometry::load_known_object("duck").mesh;
  for (int i = 0; i < state.range(1); ++i) surface = subdivided(surface);
  const geometry::MeshQuery mesh(std::move(surface));
  const geometry::CapsuleCollider collider(mesh);
  RandomStream random(1);
  const geometry::RoundedHull tip = convex_tip(static_cast<int>(state.range(0)), random);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < 256; ++i) {
    const geometry::ClosestPoint near = mesh.closest_point(0.1 * random.unit_vector());
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(random.uniform(0, 3), random.unit_vector()).toRotationMatrix();
    double low = 0;  // of the tip along the normal
    for (const auto& p : tip.core()) low = std::min(low, near.normal.dot(T.linear() * p));
    T.translation() = near.point + (tip.radius() - 0.0002 - low) * near.normal;
    poses.push_back(T);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(collider.contacts(tip, poses[i++ % poses.size()], 0, 4));
  }
  state.counters["triangles"] = static_cast<double>(mesh.mesh().triangles.size());
}
BENCHMARK(meet_convex_fingertip)
    ->ArgNames({"corners", "cuts"})
    ->Args({8, 0})
    ->Args({8, 2})
    ->Args({52, 0})
    ->Args({52, 2})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
