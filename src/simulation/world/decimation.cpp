// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/decimation.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <queue>
#include <tuple>
#include <vector>

namespace palpate::simulation {
namespace {

// A triangle may turn by this much when a corner of it moves, or it would fold over.
constexpr double kMinCosine = 0.2;
constexpr std::size_t kMinTriangles = 4;

/// Mean squared distance to planes, weighted by the areas of the triangles that lie in them.
struct Quadric {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0, area = 0;

  void add(const Quadric& other) {
    A += other.A;
    b += other.b;
    c += other.c;
    area += other.area;
  }
  double at(const Eigen::Vector3d& p) const {
    return area > 0 ? std::max(0.0, p.dot(A * p) + 2 * b.dot(p) + c) / area : 0;
  }
};

/// A vertex moves onto a neighbour and is gone.
struct Collapse {
  double cost;  // m^2
  int from, onto;
  int from_version, onto_version;  // of the vertices' quadrics

  bool operator>(const Collapse& other) const {
    return std::tie(cost, from, onto) > std::tie(other.cost, other.from, other.onto);
  }
};

class Decimation {
 public:
  explicit Decimation(const geometry::TriangleMesh& mesh)
      : mesh_(mesh),
        quadrics_(mesh.vertices.size()),
        versions_(mesh.vertices.size(), 0),
        triangles_of_(mesh.vertices.size()),
        left_(mesh.triangles.size()) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add_triangle(t);
    for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) propose(v);
  }

  void reduce_to(std::size_t triangles, double cost) {
    while (left_ > std::max(triangles, kMinTriangles) && !queue_.empty()) {
      const Collapse next = queue_.top();
      queue_.pop();
      if (next.cost > cost) return;
      if (is_current(next) && keeps_topology(next) && folds_nothing(next)) perform(next);
    }
  }

  geometry::TriangleMesh result() const {
    geometry::TriangleMesh result;
    std::vector<int> renumbered(mesh_.vertices.size(), -1);
    for (const auto& triangle : mesh_.triangles) {
      if (triangle[0] < 0) continue;
      auto& kept = result.triangles.emplace_back(triangle);
      for (int& v : kept) {
        int& number = renumbered[static_cast<std::size_t>(v)];
        if (number < 0) {
          number = static_cast<int>(result.vertices.size());
          result.vertices.push_back(vertex(v));
        }
        v = number;
      }
    }
    return result;
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  const Eigen::Vector3d& vertex(int v) const { return mesh_.vertices[at(v)]; }

  /// Twice the area along the normal.
  Eigen::Vector3d area_vector(const std::array<int, 3>& t) const {
    return (vertex(t[1]) - vertex(t[0])).cross(vertex(t[2]) - vertex(t[0]));
  }

  void add_triangle(std::size_t t) {
    const auto& triangle = mesh_.triangles[t];
    const Eigen::Vector3d across = area_vector(triangle);
    const double area = across.norm() / 2;
    Quadric plane;
    if (area > 0) {
      const Eigen::Vector3d n = across.normalized();
      const double d = -n.dot(vertex(triangle[0]));
      plane = {area * n * n.transpose(), area * d * n, area * d * d, area};
    }
    for (const int v : triangle) {
      triangles_of_[at(v)].push_back(t);
      quadrics_[at(v)].add(plane);
    }
  }

  std::vector<int> neighbours(int v) const {
    std::vector<int> result;
    for (const std::size_t t : triangles_of_[at(v)]) {
      for (const int other : mesh_.triangles[t]) {
        if (other != v) result.push_back(other);
      }
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }

  void propose(int from, int onto) {
    Quadric sum = quadrics_[at(from)];
    sum.add(quadrics_[at(onto)]);
    queue_.push({sum.at(vertex(onto)), from, onto, versions_[at(from)], versions_[at(onto)]});
  }
  void propose(int v) {
    for (const int other : neighbours(v)) propose(v, other);
  }

  bool is_current(const Collapse& c) const {
    return versions_[at(c.from)] == c.from_version && versions_[at(c.onto)] == c.onto_version;
  }

  /// The link condition (Dey et al. 1999): the surface stays a manifold, and of its kind.
  bool keeps_topology(const Collapse& c) const {
    const std::vector<int> a = neighbours(c.from), b = neighbours(c.onto);
    std::vector<int> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    return common.size() == 2;
  }

  bool folds_nothing(const Collapse& c) const {
    return std::ranges::all_of(triangles_of_[at(c.from)], [&](std::size_t t) {
      auto triangle = mesh_.triangles[t];
      if (std::ranges::find(triangle, c.onto) != triangle.end()) return true;
      const Eigen::Vector3d before = area_vector(triangle);
      std::ranges::replace(triangle, c.from, c.onto);
      const Eigen::Vector3d after = area_vector(triangle);
      return before.dot(after) > kMinCosine * before.norm() * after.norm();
    });
  }

  void perform(const Collapse& c) {
    for (const std::size_t t : triangles_of_[at(c.from)]) {
      auto& triangle = mesh_.triangles[t];
      if (std::ranges::find(triangle, c.onto) == triangle.end()) {
        std::ranges::replace(triangle, c.from, c.onto);
        triangles_of_[at(c.onto)].push_back(t);
        continue;
      }
      for (const int v : triangle) {
        if (v != c.from) std::erase(triangles_of_[at(v)], t);
      }
      triangle = {-1, -1, -1};
      --left_;
    }
    triangles_of_[at(c.from)].clear();
    ++versions_[at(c.from)];
    ++versions_[at(c.onto)];
    quadrics_[at(c.onto)].add(quadrics_[at(c.from)]);
    for (const int other : neighbours(c.onto)) {
      propose(c.onto, other);
      propose(other, c.onto);
    }
  }

  geometry::TriangleMesh mesh_;  // triangles that are gone have corners -1
  std::vector<Quadric> quadrics_;
  std::vector<int> versions_;
  std::vector<std::vector<std::size_t>> triangles_of_;
  std::size_t left_;
  std::priority_queue<Collapse, std::vector<Collapse>, std::greater<>> queue_;
};

}  // namespace

geometry::TriangleMesh decimated(const geometry::TriangleMesh& mesh, std::size_t triangles,
                                 double error) {
  if (mesh.triangles.size() <= triangles) return mesh;
  geometry::TriangleMesh centered = mesh;  // quadrics of small numbers
  const Eigen::Vector3d origin = mesh.vertices.front();
  for (Eigen::Vector3d& v : centered.vertices) v -= origin;
  Decimation decimation(centered);
  decimation.reduce_to(triangles, error * error);
  geometry::TriangleMesh result = decimation.result();
  for (Eigen::Vector3d& v : result.vertices) v += origin;
  return result;
}

}  // namespace palpate::simulation
