// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiment.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/world/open_loop_grasp.hpp"

namespace {

using namespace palpate;

constexpr double kMinForce = 0.01;          // N, of contacts that count
constexpr double kConeTolerance = 1e-6;     // of the force
constexpr double kNearby = 0.05;            // of the way to the axis
constexpr double kTall = 0.1, kLow = 0.06;  // m: from the side, from both, from above
constexpr double kDegrees = 180 / std::numbers::pi;

/// What the contacts of one object's grasps were like.
struct Tally {
  std::vector<double> angles_deg, offsets_mm, momentum_errors;
  std::size_t contacts = 0, in_cone = 0, many = 0, tip_steps = 0;
  int grasps = 0, lifted = 0;
};

/// A fingertip contact in the object's frame.
struct Place {
  Eigen::Vector3d point, normal;  // on the surface, outward
  Eigen::Vector3d on_axis;        // nearest place of the tip's axis
};

Place place_of(const simulation::ObjectStep& step, const simulation::ObjectContact& contact) {
  const Eigen::Isometry3d T_object_world = step.T_world_object.inverse();
  const Eigen::Vector3d n_world = -contact.T_world_contact.linear().col(0);  // outward
  Place place;
  place.point = T_object_world * Eigen::Vector3d(contact.T_world_contact.translation() -
                                                 0.5 * contact.distance * n_world);
  place.normal = T_object_world.linear() * n_world;
  const Eigen::Vector3d a = T_object_world * contact.capsule.a;
  const Eigen::Vector3d axis = T_object_world * contact.capsule.b - a;
  const double s = std::clamp(axis.dot(place.point - a) / axis.squaredNorm(), 0.0, 1.0);
  place.on_axis = a + s * axis;
  return place;
}

/// The contact against the closest point of the true mesh to the tip's axis. A tip's deepest
/// contact is where the mesh is closest of all. Others are closest only among their surroundings:
/// they are sought from nearer by, so that the deepest one does not come first.
void compare(const geometry::MeshQuery& mesh, const Place& place, bool is_deepest, Tally& tally) {
  const double way = is_deepest ? 1.0 : kNearby;
  const Eigen::Vector3d from = place.point + way * (place.on_axis - place.point);
  const geometry::ClosestPoint closest = mesh.closest_point(from);
  const double side = mesh.inside(from) ? -1 : 1;
  const Eigen::Vector3d expected = side * (from - closest.point).normalized();
  const double cosine = std::clamp(expected.dot(place.normal), -1.0, 1.0);
  tally.angles_deg.push_back(std::acos(cosine) * kDegrees);
  tally.offsets_mm.push_back((place.point - closest.point).norm() * 1000);
}

/// The deepest contact of the same fingertip.
double deepest_of(const simulation::ObjectStep& step, int finger) {
  double least = 1;
  for (const simulation::ObjectContact& contact : step.contacts) {
    if (contact.finger == finger) least = std::min(least, contact.distance);
  }
  return least;
}

void judge(const geometry::MeshQuery& mesh, const simulation::ObjectStep& step, double time_step,
           Tally& tally) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  hand::PerFinger<int> of_finger{};
  for (const simulation::ObjectContact& contact : step.contacts) {
    sum += contact.T_world_contact.linear() * contact.wrench.tail<3>();
    if (contact.finger < 0 || contact.wrench[3] < kMinForce) continue;
    const Eigen::VectorXd force = grasping::transmission(contact.model) * contact.wrench;
    ++tally.contacts;
    ++of_finger[static_cast<std::size_t>(contact.finger)];
    tally.in_cone += grasping::is_within_cone(contact.model, contact.friction, force,
                                              kConeTolerance * contact.wrench.tail<3>().norm());
    compare(mesh, place_of(step, contact), contact.distance <= deepest_of(step, contact.finger),
            tally);
  }
  for (const int count : of_finger) {
    tally.many += count > 1;
    tally.tip_steps += count > 0;
  }
  const Eigen::Vector3d expected = step.momentum_change / time_step - step.gravity;
  tally.momentum_errors.push_back((sum - expected).norm() /
                                  std::max(expected.norm(), step.gravity.norm()));
}

Tally grasp_object(const std::string& name, int grasps, std::uint64_t seed) {
  const geometry::KnownObject object = geometry::load_known_object(name);
  const geometry::MeshQuery mesh(object.mesh);
  const simulation::WorldOptions options;
  simulation::World world(object, options, seed);
  Tally tally;
  world.observe(
      [&](const simulation::ObjectStep& step) { judge(mesh, step, options.time_step, tally); });
  for (int i = 0; i < grasps; ++i) {
    RandomStream random = RandomStream(seed, "grasp").fork(name, static_cast<std::uint64_t>(i));
    simulation::OpenLoopGrasp grasp;
    grasp.start.yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    grasp.start.xy << random.uniform(-0.005, 0.005), random.uniform(-0.005, 0.005);
    const double top = 2 * object.stable_poses.front().height;
    grasp.side = top > kTall || (top > kLow && i % 2 == 1);
    if (!grasp.side) grasp.height = 0.5 * top + 0.015;
    tally.lifted += simulation::run_open_loop_grasp(world, grasp);
    ++tally.grasps;
  }
  return tally;
}

std::string three(const std::vector<double>& values, const char* format) {
  if (values.empty()) return "-";
  return fmt::format("{} / {} / {}", fmt::format(fmt::runtime(format), median(values)),
                     fmt::format(fmt::runtime(format), quantile(values, 0.95)),
                     fmt::format(fmt::runtime(format), quantile(values, 1)));
}

std::string share(std::size_t part, std::size_t whole) {
  if (whole == 0) return "-";
  return fmt::format("{:.4f}", static_cast<double>(part) / static_cast<double>(whole));
}

/// Share of the values at or below x, on a logarithmic axis.
plotting::LineSeries distribution(const std::string& name, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  plotting::LineSeries series{.name = name, .x = {}, .y = {}};
  constexpr std::size_t kPoints = 200;
  for (std::size_t i = 0; i <= kPoints; ++i) {
    const std::size_t at = i * (values.size() - 1) / kPoints;
    series.x.push_back(std::max(values[at], 1e-6));
    series.y.push_back(static_cast<double>(at + 1) / static_cast<double>(values.size()));
  }
  return series;
}

void run(const experiment::Options& options) {
  experiment::Table table({"object", "grasps (lifted)", "tip contacts",
                           "angle median / p95 / max deg", "position median / p95 / max mm",
                           "force in the cone", "momentum median / p95 / max %",
                           "tips with two contacts"});
  plotting::Plot angles;
  angles.title = "Solver's contact normal against closest point to tip axis";
  angles.x.label = "angle (deg)";
  angles.x.logarithmic = true;
  angles.x.low = 1e-6;
  angles.x.high = 180;
  angles.y.label = "share of contacts";
  const std::vector<std::string> objects =
      options.quick ? std::vector<std::string>{"bracket"}
                    : std::vector<std::string>{"bunny", "mug", "bracket", "bottle", "box"};
  for (const std::string& name : objects) {
    const Tally tally = grasp_object(name, options.quick ? 1 : 10, options.seed);
    std::vector<double> momentum = tally.momentum_errors;
    for (double& error : momentum) error *= 100;
    table.add_row({name, fmt::format("{} ({})", tally.grasps, tally.lifted),
                   std::to_string(tally.contacts), three(tally.angles_deg, "{:.3f}"),
                   three(tally.offsets_mm, "{:.4f}"), share(tally.in_cone, tally.contacts),
                   three(momentum, "{:.3f}"), share(tally.many, tally.tip_steps)});
    if (tally.contacts > 0) angles.series.emplace_back(distribution(name, tally.angles_deg));
  }
  table.publish(options, "contact_exactness", "Fingertip contacts in grasps, every physics step");
  experiment::publish_figure(options, "contact_angles", plotting::to_svg(angles));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "contact_exactness",
                         "Checks the solver's fingertip contacts in grasps against the true "
                         "surface, the friction cone and the object's momentum.",
                         run);
}
