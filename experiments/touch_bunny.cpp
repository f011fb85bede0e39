// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "../tests/touch/sliding_score.hpp"
#include "experiment.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plot.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/core/version.hpp"
#include "palpate/recording/writer.hpp"
#include "touch_surfaces.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

constexpr double kPi = std::numbers::pi;
constexpr double kSeconds = 30;    // of each finger's sampling
constexpr double kLowest = 1.25;   // rad from straight up, where the ways end
constexpr double kSmoothing = 25;  // ticks, over which the way is smoothed

/// A point of contact as it was sensed, in the world.
struct Touched {
  int finger = 0;
  double time = 0;
  Eigen::Vector3d p, n, f;
  double point_error = 0;       // from the object's surface, m
  double normal_error_deg = 0;  // from the normal where the tip really touched
};

/// A way from the top down and round, to and fro, over a quarter of the object.
TipPath spiral_over(const geometry::MeshQuery& mesh, const Eigen::Isometry3d& T_world_object,
                    double tip_radius, int quarter, double seconds) {
  TipPath path;
  double reach = 0;
  for (const auto& v : mesh.mesh().vertices) reach = std::max(reach, 2 * v.norm());
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (int i = 0; i * hand::kTick < seconds; ++i) {
    const double share = i * hand::kTick / seconds;
    const double polar = kLowest * std::sqrt(0.02 + 0.98 * share);
    const double azimuth =
        kPi / 2 * (quarter + 0.5 + 0.6 * std::sin(2 * kPi * share * seconds / 6));
    const Eigen::Vector3d out(std::sin(polar) * std::cos(azimuth),
                              std::sin(polar) * std::sin(azimuth), std::cos(polar));
    const auto hit = mesh.raycast(T_world_object.linear().transpose() * (reach * out),
                                  T_world_object.linear().transpose() * -out, reach);
    const double distance = hit ? reach - hit->distance : 0;
    const Eigen::Vector3d wanted = T_world_object.translation() + (distance + tip_radius) * out;
    center = i == 0 ? wanted : Eigen::Vector3d(center + (wanted - center) / kSmoothing);
    path.center.push_back(center);
    path.normal.push_back(out);
  }
  return path;
}

/// Every contact of a slide with its smoothed normal.
std::vector<Touched> sense(const std::vector<SlideTick>& ticks, const hand::HandModel& hand,
                           const geometry::MeshQuery& mesh, int finger) {
  std::vector<Touched> touched;
  std::vector<touch::FingerSample> samples;
  touch::SampleMaker maker;
  const auto estimator = touch::make_normal_estimator("s2-lag");
  for (const SlideTick& tick : ticks) {
    samples.push_back(maker.next(touch::finger_frame(tick.frame.reading, hand, finger)));
    const auto estimate = estimator->update(samples.back());
    if (estimate.status != touch::NormalStatus::tracked) continue;
    const auto at = static_cast<std::size_t>(std::lround(estimate.time / hand::kTick)) - 1;
    const auto& truth = ticks.at(at).true_normals;
    if (truth.empty()) continue;
    double error = 180;
    for (const auto& n : truth) error = std::min(error, touch::angle_deg(estimate.n, n));
    const auto& felt = samples[at];
    const Eigen::Isometry3d& T = ticks[at].frame.truth->T_world_object;
    const double off = mesh.closest_point(T.inverse() * felt.p).distance;
    touched.push_back({finger, felt.time, felt.p, estimate.n, felt.f, off, error});
  }
  return touched;
}

void record(const std::vector<SlideTick>& ticks, const geometry::KnownObject& object,
            const hand::HandModel& hand, int finger, const Options& options) {
  const auto name = hand::kFingerNames[static_cast<std::size_t>(finger)];
  recording::Writer writer(options.out / fmt::format("bunny-{}.h5", name),
                           {std::string(version()), options.seed, object, hand, ""});
  for (const SlideTick& tick : ticks) writer.frame(tick.frame);
  writer.finish();
}

std::string contacts_csv(const std::vector<Touched>& touched) {
  std::string text = "x,y,z,nx,ny,nz,finger,t,fx,fy,fz\n";
  for (const Touched& c : touched) {
    text += fmt::format(
        "{:.6f},{:.6f},{:.6f},{:.5f},{:.5f},{:.5f},{},{:.2f},{:.4f},{:.4f},{:.4f}\n", c.p.x(),
        c.p.y(), c.p.z(), c.n.x(), c.n.y(), c.n.z(),
        hand::kFingerNames[static_cast<std::size_t>(c.finger)], c.time, c.f.x(), c.f.y(), c.f.z());
  }
  return text;
}

/// Touched points over the object's vertices, seen along the third axis.
std::string view(const std::vector<Touched>& touched, const geometry::KnownObject& object,
                 const Eigen::Vector3d& place, const std::array<int, 2>& axes) {
  Plot plot;
  plot.title = "Points touched by the fingers, over the bunny";
  plot.width = plot.height = 560;
  plot.x.label = fmt::format("{} (mm)", "xyz"[axes[0]]);
  plot.y.label = fmt::format("{} (mm)", "xyz"[axes[1]]);
  ScatterSeries mesh{.name = "mesh", .x = {}, .y = {}};
  for (const Eigen::Vector3d& v : object.mesh.vertices) {
    mesh.x.push_back(1e3 * (v + place)[axes[0]]);
    mesh.y.push_back(1e3 * (v + place)[axes[1]]);
  }
  plot.series.emplace_back(std::move(mesh));
  for (int finger = 1; finger < hand::kFingers; ++finger) {
    ScatterSeries points{.name = std::string(hand::kFingerNames[static_cast<std::size_t>(finger)]),
                         .x = {},
                         .y = {}};
    for (std::size_t i = 0; i < touched.size(); i += 5) {
      if (touched[i].finger != finger) continue;
      points.x.push_back(1e3 * touched[i].p[axes[0]]);
      points.y.push_back(1e3 * touched[i].p[axes[1]]);
    }
    plot.series.emplace_back(std::move(points));
  }
  return to_svg(plot);
}

void experiment_bunny(const Options& options) {
  const auto object = fixed_object("bunny", geometry::load_known_object("bunny").mesh);
  const geometry::MeshQuery mesh(object.mesh);
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  T_world_object.translation().z() = object.stances[0].height;
  Table table({"finger", "points", "off the surface, median mm", "normals, median / p95 deg"});
  std::vector<Touched> all;
  for (int finger = 1; finger < hand::kFingers; ++finger) {
    SlidingFinger sliding(object, sliding_world(), options.seed, finger);
    const auto path = spiral_over(mesh, T_world_object, sliding.tip_radius(), finger - 1,
                                  options.quick ? 2 : kSeconds);
    const auto ticks = sliding.follow(path, {}, kPress);
    record(ticks, object, sliding.believed_hand(), finger, options);
    const auto touched = sense(ticks, sliding.believed_hand(), mesh, finger);
    std::vector<double> off, errors;
    for (const Touched& c : touched) {
      off.push_back(1e3 * c.point_error);
      errors.push_back(c.normal_error_deg);
    }
    const std::string name(hand::kFingerNames[static_cast<std::size_t>(finger)]);
    if (touched.empty()) {
      table.add_row({name, "0", "-", "-"});
      continue;
    }
    table.add_row({name, std::to_string(touched.size()), fmt::format("{:.2f}", median(off)),
                   fmt::format("{:.1f} / {:.1f}", median(errors), quantile(errors, 0.95))});
    all.insert(all.end(), touched.begin(), touched.end());
  }
  table.publish(
      options, "points",
      "Points sampled on the bunny: distance from its surface, normals where the tip touched");
  write_file_atomically(options.out / "contacts.csv", contacts_csv(all));
  publish_figure(options, "points_xy", view(all, object, T_world_object.translation(), {0, 1}));
  publish_figure(options, "points_xz", view(all, object, T_world_object.translation(), {0, 2}));
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "touch_bunny",
             "The four fingers sample the bunny (thesis figure 5.11); recordings and a CSV of the "
             "contacts",
             experiment_bunny);
}
