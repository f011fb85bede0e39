// SPDX-License-Identifier: Apache-2.0
// By how little a shape changes where it is rotated about the axis that changes it least: what is
// less than the error of its surface cannot be sensed.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace {

using namespace palpate;

constexpr std::uint64_t kShapes = 100;
constexpr std::size_t kPoints = 250;  // of the surface
constexpr int kAxes = 150, kSteps = 60;
constexpr double kFirstStep = 0.08, kShrink = 0.95;
constexpr double kDegree = std::numbers::pi / 180;
constexpr std::array<double, 3> kAngles = {5, 10, 30};  // deg
constexpr double kSearched = 10;                        // deg, by which the axis is chosen

class Shape {
 public:
  explicit Shape(const geometry::KnownObject& object)
      : surface_(object.mesh),
        points_(geometry::sample_surface(object.mesh, kPoints, RandomStream(0, "points"))) {}

  /// Root mean square distance of the rotated surface from the original, m.
  [[nodiscard]] double change(const Eigen::Vector3d& axis, double degrees) const {
    const Eigen::AngleAxisd rotation(degrees * kDegree, axis);
    double sum = 0;
    for (const auto& sample : points_) {
      const double apart = surface_.closest_point(rotation * sample.point).distance;
      sum += apart * apart;
    }
    return std::sqrt(sum / static_cast<double>(points_.size()));
  }

  /// The axis through the centroid about which a rotation changes the surface least.
  [[nodiscard]] Eigen::Vector3d weakest_axis() const {
    RandomStream random(0, "axes");
    Eigen::Vector3d best = random.unit_vector();
    double least = change(best, kSearched);
    const auto keep_better = [&](const Eigen::Vector3d& axis) {
      const double found = change(axis, kSearched);
      if (found >= least) return false;
      least = found;
      best = axis;
      return true;
    };
    for (int i = 0; i < kAxes; ++i) keep_better(random.unit_vector());
    double step = kFirstStep;
    for (int i = 0; i < kSteps; ++i) {
      if (!keep_better((best + step * random.normal3()).normalized())) step *= kShrink;
    }
    return best;
  }

 private:
  geometry::MeshQuery surface_;
  std::vector<geometry::SurfaceSample> points_;
};

std::vector<std::string> row(const std::string& name) {
  const auto object = geometry::load_known_object(name);
  const Shape shape(object);
  const Eigen::Vector3d axis = shape.weakest_axis();
  std::vector<std::string> cells = {name, fmt::format("{}", object.symmetries.size())};
  for (const double angle : kAngles) {
    cells.push_back(fmt::format("{:.3f}", 1e3 * shape.change(axis, angle)));
  }
  return cells;
}

void near_symmetry(const experiment::Options& options) {
  std::vector<std::vector<std::string>> rows(options.quick ? 1 : kShapes);
  parallel_for(rows.size(), options.threads, [&](std::size_t i) {
    rows[i] = row(fmt::format("generated:{}", options.seed + i));
  });
  experiment::Table table(
      {"shape", "symmetries", "mm rms after 5 deg", "after 10 deg", "after 30 deg"});
  for (auto& cells : rows) table.add_row(std::move(cells));
  table.publish(options, "near_symmetry", "Change of the surface about its weakest axis");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "near_symmetry",
                         "By how little shapes change as they rotate about their weakest axis",
                         near_symmetry);
}
