// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/drawn_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "palpate/core/se3.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/world/convex_parts.hpp"

namespace palpate::simulation {
namespace {

constexpr std::array<double, 2> kWavelengths = {0.03, 0.12};  // m, of dents
constexpr int kWaves = 12;
constexpr double kMinFriction = 0.05;

double up_to(double most, RandomStream& random) { return random.uniform(-most, most); }

/// A vector whose length has that root mean square.
Eigen::Vector3d of_rms(double rms, RandomStream& random) {
  return rms / std::sqrt(3.0) * random.normal3();
}

/// A smooth displacement of space.
class Dents {
 public:
  Dents(double rms, RandomStream random) {
    for (Wave& wave : waves_) {
      const double length = random.uniform(kWavelengths[0], kWavelengths[1]);
      wave.k = 2 * std::numbers::pi / length * random.unit_vector();
      wave.phase = random.uniform(0, 2 * std::numbers::pi);
      wave.way = of_rms(rms * std::sqrt(2.0 / kWaves), random);
    }
  }

  /// Takes off what moves the surface as a whole: a scan is aligned with what it shows.
  void align(const geometry::TriangleMesh& mesh) {
    Matrix6d A = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    for (const auto& triangle : mesh.triangles) {
      const auto corner = [&](int i) -> const Eigen::Vector3d& {
        return mesh.vertices[static_cast<std::size_t>(triangle[static_cast<std::size_t>(i)])];
      };
      const double area = (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
      const Eigen::Vector3d p = (corner(0) + corner(1) + corner(2)) / 3;
      Eigen::Matrix<double, 3, 6> J;
      J << Eigen::Matrix3d::Identity(), -skew(p);
      A += area * J.transpose() * J;
      b += area * J.transpose() * waves(p);
    }
    rigid_ = A.ldlt().solve(b);
  }

  Eigen::Vector3d at(const Eigen::Vector3d& p) const {
    return waves(p) - rigid_.head<3>() - rigid_.tail<3>().cross(p);
  }

 private:
  struct Wave {
    Eigen::Vector3d k, way;
    double phase = 0;
  };

  Eigen::Vector3d waves(const Eigen::Vector3d& p) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Wave& wave : waves_) sum += wave.way * std::sin(wave.k.dot(p) + wave.phase);
    return sum;
  }

  std::array<Wave, kWaves> waves_;
  Vector6d rigid_ = Vector6d::Zero();  // shift and turn
};

void deform(geometry::TriangleMesh& mesh, double scale, const Dents& dents) {
  for (Eigen::Vector3d& p : mesh.vertices) p = scale * p + dents.at(p);
}

}  // namespace

WorldErrors WorldErrors::realistic() {
  return {.mount = 0.001,
          .mount_angle = 0.0052,
          .table_height = 0.005,
          .table_tilt = 0.0175,
          .load_bias = 0.3,
          .load_drift = 0.1 / 60,
          .hand_weight = 0.02,
          .torque = 0.1,
          .torque_friction = 0.05,
          .friction = 0.3,
          .mass = 0.2,
          .center = 0.005,
          .scale = 0.01,
          .surface = 0.0005};
}

WorldOptions WorldOptions::realistic() {
  WorldOptions options;
  options.hand_friction = options.table_friction = 0.7;
  options.noise = SensorNoise::realistic();
  options.error = WorldErrors::realistic();
  return options;
}

SolidObject believed_object(const geometry::KnownObject& known) {
  return {known, convex_parts(known.mesh)};
}

SolidObject differing_object(SolidObject solid, const WorldErrors& error,
                             const RandomStream& random) {
  RandomStream shape = random.fork("shape"), load = random.fork("mass");
  if (error.scale > 0 || error.surface > 0) {
    const double scale = 1 + up_to(error.scale, shape);
    Dents dents(error.surface, shape);
    dents.align(solid.object.mesh);
    deform(solid.object.mesh, scale, dents);
    for (geometry::TriangleMesh& part : solid.parts) deform(part, scale, dents);
  }
  if (error.mass > 0 || error.center > 0) {
    const double share = 1 + up_to(error.mass, load);
    solid.object.mass *= share;
    solid.object.mass_properties.inertia *= share;
    solid.object.mass_properties.centroid += of_rms(error.center, load);
  }
  return solid;
}

WorldOptions with_drawn_friction(WorldOptions options, const RandomStream& random) {
  if (options.error.friction == 0) return options;
  RandomStream draw = random.fork("friction");
  for (double* friction : {&options.hand_friction, &options.table_friction}) {
    *friction = std::max(kMinFriction, *friction + up_to(options.error.friction, draw));
  }
  return options;
}

Eigen::Matrix3d drawn_tilt(const WorldErrors& error, const RandomStream& random) {
  RandomStream draw = random.fork("tilt");
  const double heading = draw.uniform(0, 2 * std::numbers::pi);
  const Eigen::Vector3d axis(std::cos(heading), std::sin(heading), 0);
  return Eigen::AngleAxisd(error.table_tilt * draw.uniform(), axis).toRotationMatrix();
}

hand::Description believed_hand(hand::Description hand, const WorldOptions& options,
                                const RandomStream& random) {
  if (options.noise.link > 0) {
    RandomStream links = random.fork("links");
    hand = hand::with_perturbed_links(std::move(hand), options.noise.link, links);
  }
  const WorldErrors& error = options.error;
  if (error.mount == 0 && error.mount_angle == 0) return hand;
  RandomStream mount = random.fork("mount");
  const Eigen::Vector3d turn = of_rms(error.mount_angle, mount);
  Eigen::Isometry3d T_true_believed = Eigen::Isometry3d::Identity();
  T_true_believed.translation() = of_rms(error.mount, mount);
  T_true_believed.rotate(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
  for (hand::Link& link : hand.links) {
    if (link.parent < 0) link.T_parent_link = T_true_believed * link.T_parent_link;
  }
  return hand;
}

}  // namespace palpate::simulation
