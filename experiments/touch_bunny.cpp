// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/core/version.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/recording/writer.hpp"
#include "reach.hpp"
#include "tactile/sliding_score.hpp"
#include "touch_surfaces.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

constexpr double kSeconds = 30;     // of each way
constexpr double kSmoothing = 25;   // ticks, over which the way is smoothed
constexpr double kGuardedMove = 6;  // s, to and fro
constexpr double kTouched = 0.006;  // m, from a touch: that much of the surface counts as touched
constexpr double kAbove = 0.0015;   // m, of a tip that is not meant to touch yet

/// Of the two ways of each finger over its fifth of the object, from straight up (rad).
struct Band {
  std::string name;
  double high, low;
};
const Band kBands[] = {{"upper", 0.15, 1.25}, {"lower", 1.15, 2.3}};

/// A point of contact as it was sensed, in the world.
struct Touched {
  int finger = 0;
  double time = 0;
  Eigen::Vector3d p, n, f;
  double point_error = 0;       // from the object's surface, m
  double normal_error_deg = 0;  // from the normal where the tip really touched
};

double azimuth_of(int finger) { return 2 * kPi * (finger + 0.5) / hand::kShadowFingers; }

/// A way down and round, to and fro, over a fifth of the object; never so low that the tip would
/// touch the table.
TipPath way_over(const geometry::MeshQuery& mesh, const Eigen::Isometry3d& T_world_object,
                 double tip_radius, int finger, const Band& band, double seconds) {
  TipPath path;
  double reach = 0;
  for (const auto& v : mesh.mesh().vertices) reach = std::max(reach, 2 * v.norm());
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (int i = 0; i * hand::kTick < seconds; ++i) {
    const double t = i * hand::kTick;
    const double polar = band.high + (band.low - band.high) * t / seconds;
    const double azimuth = azimuth_of(finger) +
                           1.2 * kPi / hand::kShadowFingers * std::sin(2 * kPi * t / kGuardedMove);
    const Eigen::Vector3d out(std::sin(polar) * std::cos(azimuth),
                              std::sin(polar) * std::sin(azimuth), std::cos(polar));
    const auto hit = mesh.raycast(T_world_object.linear().transpose() * (reach * out),
                                  T_world_object.linear().transpose() * -out, reach);
    const double distance = hit ? reach - hit->distance : 0;
    Eigen::Vector3d wanted = T_world_object.translation() + (distance + tip_radius) * out;
    wanted.z() = std::max(wanted.z(), tip_radius + 0.003);
    center = i == 0 ? wanted : Eigen::Vector3d(center + (wanted - center) / kSmoothing);
    path.center.push_back(center);
    // Pressed from the side where the tip cannot go under the object.
    path.normal.push_back(Eigen::Vector3d(out.x(), out.y(), std::max(out.z(), 0.0)).normalized());
  }
  return path;
}

/// Some places of a way, a little off the surface.
std::vector<Eigen::Vector3d> places_of(const TipPath& path) {
  std::vector<Eigen::Vector3d> places;
  const std::size_t step = std::max<std::size_t>(1, path.center.size() / 20);
  for (std::size_t i = 0; i < path.center.size(); i += step) {
    places.push_back(path.center[i] + kAbove * path.normal[i]);
  }
  return places;
}

/// Every contact of a slide with its smoothed normal.
std::vector<Touched> sense(const std::vector<SlideTick>& ticks, const hand::Description& hand,
                           const geometry::MeshQuery& mesh, int finger) {
  std::vector<Touched> touched;
  std::vector<tactile::FingerSample> samples;
  tactile::SampleMaker maker;
  const auto estimator = tactile::make_normal_estimator("s2-lag");
  for (const SlideTick& tick : ticks) {
    samples.push_back(maker.next(tactile::finger_frame(tick.frame.reading, hand, finger)));
    const auto estimate = estimator->update(samples.back());
    if (estimate.status != tactile::NormalStatus::tracked) continue;
    const auto at = static_cast<std::size_t>(std::lround(estimate.time / hand::kTick)) - 1;
    const auto& truth = ticks.at(at).true_normals;
    if (truth.empty()) continue;
    double error = 180;
    for (const auto& n : truth) error = std::min(error, tactile::angle_between_deg(estimate.n, n));
    const auto& sample = samples[at];
    const Eigen::Isometry3d& T = ticks[at].frame.truth->T_world_object;
    const double off = mesh.closest_point(T.inverse() * sample.p).distance;
    touched.push_back({finger, sample.time, sample.p, estimate.n, sample.f, off, error});
  }
  return touched;
}

void record(const std::vector<SlideTick>& ticks, const geometry::KnownObject& object,
            const hand::Description& hand, const std::string& name, const Options& options) {
  recording::Writer writer(options.out / fmt::format("bunny-{}.h5", name),
                           {std::string(version()), options.seed, object, hand, ""});
  for (const SlideTick& tick : ticks) writer.frame(tick.frame);
  writer.finish();
}

std::string contacts_csv(const std::vector<Touched>& touched) {
  std::string text = "x,y,z,nx,ny,nz,finger,t,fx,fy,fz\n";
  for (const Touched& c : touched) {
    text +=
        fmt::format("{:.6f},{:.6f},{:.6f},{:.5f},{:.5f},{:.5f},{},{:.2f},{:.4f},{:.4f},{:.4f}\n",
                    c.p.x(), c.p.y(), c.p.z(), c.n.x(), c.n.y(), c.n.z(),
                    hand::kShadowFingerNames[static_cast<std::size_t>(c.finger)], c.time, c.f.x(),
                    c.f.y(), c.f.z());
  }
  return text;
}

/// Touched points over the object's vertices, seen along the third axis.
std::string view(const std::vector<Touched>& touched, const geometry::KnownObject& object,
                 const Eigen::Vector3d& place, const std::array<int, 2>& axes) {
  plotting::Plot plot;
  plot.title = "Points touched by the fingers, over the bunny";
  plot.width = plot.height = 560;
  plot.x.label = fmt::format("{} (mm)", "xyz"[axes[0]]);
  plot.y.label = fmt::format("{} (mm)", "xyz"[axes[1]]);
  plotting::ScatterSeries mesh{.name = "mesh", .x = {}, .y = {}};
  for (const Eigen::Vector3d& v : object.mesh.vertices) {
    mesh.x.push_back(1e3 * (v + place)[axes[0]]);
    mesh.y.push_back(1e3 * (v + place)[axes[1]]);
  }
  plot.series.emplace_back(std::move(mesh));
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    plotting::ScatterSeries points{
        .name = std::string(hand::kShadowFingerNames[static_cast<std::size_t>(finger)]),
        .x = {},
        .y = {}};
    for (std::size_t i = 0; i < touched.size(); i += 5) {
      if (touched[i].finger != finger) continue;
      points.x.push_back(1e3 * touched[i].p[axes[0]]);
      points.y.push_back(1e3 * touched[i].p[axes[1]]);
    }
    plot.series.emplace_back(std::move(points));
  }
  return plotting::to_svg(plot);
}

/// Shares of the surface that were touched, by places drawn from it evenly.
struct Coverage {
  double reachable = 0, of_all = 0, of_reachable = 0;
};

Coverage coverage(const geometry::KnownObject& object, const Eigen::Isometry3d& T_world_object,
                  Reach& reach, double tip_radius, const std::vector<Touched>& touched,
                  const Options& options) {
  const std::size_t count = options.quick ? 20 : 400;
  int reachable = 0, sensed = 0, both = 0;
  for (const auto& s :
       geometry::sample_surface(object.mesh, count, RandomStream(options.seed, "coverage"))) {
    const Eigen::Vector3d p = T_world_object * s.point, n = T_world_object.linear() * s.normal;
    const bool reaches =
        reach.any_finger_reaches(std::atan2(n.y(), n.x()), p + (tip_radius + kAbove) * n);
    const bool is_touched = std::any_of(touched.begin(), touched.end(), [&](const Touched& c) {
      return (c.p - p).norm() < kTouched;
    });
    reachable += reaches;
    sensed += is_touched;
    both += reaches && is_touched;
  }
  const auto all = static_cast<double>(count);
  return {reachable / all, sensed / all, both / std::max(1.0, static_cast<double>(reachable))};
}

std::vector<std::string> row_of(const std::string& name, const Stand& stand,
                                const std::vector<Touched>& touched) {
  const std::string share = fmt::format("{:.2f}", stand.free_share);
  if (touched.empty()) return {name, share, "0", "-", "-"};
  std::vector<double> off, errors;
  for (const Touched& c : touched) {
    off.push_back(1e3 * c.point_error);
    errors.push_back(c.normal_error_deg);
  }
  return {name, share, std::to_string(touched.size()), fmt::format("{:.2f}", median(off)),
          fmt::format("{:.1f} / {:.1f}", median(errors), quantile(errors, 0.95))};
}

void experiment_bunny(const Options& options) {
  const auto object = fixed_object("bunny", geometry::load_known_object("bunny").mesh);
  const geometry::MeshQuery mesh(object.mesh);
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  T_world_object.translation().z() = object.stable_poses[0].height;
  const PointingFinger first = straight_finger(hand::FingerName::first);
  Reach reach(object, T_world_object, first.hand());
  Table table(
      {"way", "free places", "points", "off the surface, median mm", "normals, median / p95 deg"});
  std::vector<Touched> all;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    for (const Band& band : kBands) {
      auto path = way_over(mesh, T_world_object, first.tip().radius, finger, band,
                           options.quick ? 1 : kSeconds);
      const Stand stand = reach.best_stand(finger, azimuth_of(finger), places_of(path));
      path.R_world_mount = stand.R_world_mount;
      SlidingFinger sliding(object, sliding_world(), options.seed, stand.finger);
      const auto ticks = sliding.follow(path, {}, kPress);
      const auto name = fmt::format(
          "{}-{}", hand::kShadowFingerNames[static_cast<std::size_t>(finger)], band.name);
      record(ticks, object, sliding.believed_hand(), name, options);
      const auto touched = sense(ticks, sliding.believed_hand(), mesh, finger);
      table.add_row(row_of(name, stand, touched));
      all.insert(all.end(), touched.begin(), touched.end());
    }
  }
  table.publish(
      options, "points",
      "Points sampled on the bunny: distance from its surface, normals where the tip touched");
  const Coverage sensed = coverage(object, T_world_object, reach, first.tip().radius, all, options);
  Table shares({"reachable", "touched, of all", "touched, of the reachable"});
  shares.add_row({fmt::format("{:.2f}", sensed.reachable), fmt::format("{:.2f}", sensed.of_all),
                  fmt::format("{:.2f}", sensed.of_reachable)});
  shares.publish(options, "coverage", "Shares of the surface within 6 mm of a touch");
  write_file_atomically(options.out / "contacts.csv", contacts_csv(all));
  publish_figure(options, "points_xy", view(all, object, T_world_object.translation(), {0, 1}));
  publish_figure(options, "points_xz", view(all, object, T_world_object.translation(), {0, 2}));
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "touch_bunny",
             "All five fingers sample the bunny (thesis figure 5.11); recordings and a CSV of the "
             "contacts",
             experiment_bunny);
}
