// SPDX-License-Identifier: Apache-2.0
#include "touch_surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "experiment.hpp"
#include "normal_clusters.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/plotting/plot.hpp"
#include "tactile/normals/s2_smoother.hpp"
#include "tactile/sliding_score.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

constexpr int kFinger = static_cast<int>(hand::FingerName::first);
constexpr std::size_t kClusterTicks = 10;
constexpr double kSettle = 1;  // s from the start that are left out

/// Normals of one kind, with their errors (deg) where the truth is known.
struct Normals {
  std::vector<tactile::NormalAt> sensed;
  std::vector<double> error_deg, nees;
};

/// What a slide gave.
struct Slide {
  std::vector<Eigen::Vector3d> forces, torques;  // N, N m about the tip's centre
  std::map<std::string, Normals> normals;        // raw, clustered, s2, s2-lag
  std::size_t samples = 0, flagged = 0;
};

void add_error(const tactile::NormalAt& normal, const std::vector<Eigen::Vector3d>& truth,
               const std::optional<Eigen::Matrix3d>& covariance, Normals& normals) {
  if (truth.empty()) return;
  const Eigen::Vector3d& n = normal.n;
  const auto& nearest =
      *std::min_element(truth.begin(), truth.end(),
                        [&](const auto& a, const auto& b) { return a.dot(n) > b.dot(n); });
  normals.sensed.push_back(normal);
  normals.error_deg.push_back(tactile::angle_between_deg(n, nearest));
  if (covariance) {
    normals.nees.push_back(tactile::normalised_error_squared(n, nearest, *covariance));
  }
}

class SlideErrors {
 public:
  explicit SlideErrors(const hand::Description& hand) : hand_(hand) {}

  void take(const SlideTick& tick) {
    const auto& reading = tick.frame.reading;
    truth_.push_back(tick.true_normals);
    if (reading.time > kSettle) take_raw(reading);
    const auto sample = maker_.next(tactile::finger_frame(reading, hand_, kFinger));
    points_.push_back(sample.p);
    ++slide_.samples;
    slide_.flagged += sample.flags.any();
    take_estimate("s2", filter_.update(sample));
    take_estimate("s2-lag", smoother_.update(sample));
  }
  Slide finish() { return std::move(slide_); }

 private:
  /// The normals that the reader gives (the solver's, with noise), in the world.
  void take_raw(const hand::HandReading& reading) {
    const auto T_mount_link = hand::forward_kinematics(hand_, reading.joints);
    const auto finger = static_cast<std::size_t>(kFinger);
    const Eigen::Isometry3d T =
        reading.mount.pose() * T_mount_link[static_cast<std::size_t>(hand_.fingers[finger].link)];
    for (const auto& contact : reading.contacts[finger]) {
      const Eigen::Vector3d f = T.linear() * contact.f;
      slide_.forces.push_back(f);
      slide_.torques.push_back((T * contact.p - T * hand_.fingers[finger].tip.b).cross(f));
      recent_.push_back({T * contact.p, T.linear() * contact.n});
      add_error(recent_.back(), truth_.back(), {}, slide_.normals["raw"]);
    }
    if (++ticks_ % kClusterTicks != 0) return;
    for (const auto& cluster : tactile::cluster_normals(recent_)) {
      add_error({cluster.p, cluster.n}, truth_.back(), {}, slide_.normals["clustered"]);
    }
    recent_.clear();
  }

  void take_estimate(const std::string& name, const tactile::NormalEstimate& estimate) {
    if (estimate.status != tactile::NormalStatus::tracked || estimate.time < kSettle) return;
    const auto tick = static_cast<std::size_t>(std::lround(estimate.time / hand::kTick)) - 1;
    add_error({points_.at(tick), estimate.n}, truth_.at(tick), estimate.covariance,
              slide_.normals[name]);
  }

  const hand::Description& hand_;
  tactile::SampleMaker maker_;
  tactile::S2Filter filter_;
  tactile::S2Smoother smoother_;
  std::vector<std::vector<Eigen::Vector3d>> truth_;  // of every tick, the first at kTick
  std::vector<Eigen::Vector3d> points_;              // sensed in them
  std::vector<tactile::NormalAt> recent_;
  std::size_t ticks_ = 0;
  Slide slide_;
};

/// Every so many vectors, to keep a figure light.
std::string cone(const std::vector<Eigen::Vector3d>& vectors, const std::array<int, 2>& axes,
                 const std::string& title, const std::string& unit) {
  constexpr std::size_t kMost = 1500;
  plotting::Plot plot;
  plot.title = title;
  plot.width = plot.height = 480;
  plot.x.label = fmt::format("{} ({})", "xyz"[axes[0]], unit);
  plot.y.label = fmt::format("{} ({})", "xyz"[axes[1]], unit);
  plotting::ScatterSeries points;
  for (std::size_t i = 0; i < vectors.size(); i += 1 + vectors.size() / kMost) {
    points.x.push_back(vectors[i][axes[0]]);
    points.y.push_back(vectors[i][axes[1]]);
  }
  plot.series.emplace_back(std::move(points));
  return plotting::to_svg(plot);
}

/// Share of the errors in every degree.
plotting::LineSeries density(const std::string& name, const std::vector<double>& errors) {
  constexpr int kDegrees = 40;
  std::vector<double> counts(kDegrees, 0);
  for (double error : errors) {
    if (error < kDegrees) ++counts[static_cast<std::size_t>(error)];
  }
  plotting::LineSeries line{.name = name, .x = {}, .y = {}};
  for (int i = 0; i < kDegrees; ++i) {
    line.x.push_back(i + 0.5);
    line.y.push_back(counts[static_cast<std::size_t>(i)] / static_cast<double>(errors.size()));
  }
  return line;
}

/// The figures that the thesis has of the edge (the box's top and its side against x).
void draw_edge(const Slide& slide, const Options& options) {
  constexpr std::array<int, 2> kAcross = {0, 2};  // the edge runs along y
  publish_figure(options, "edge_force_cone",
                 cone(slide.forces, kAcross, "Forces at the edge", "N"));
  publish_figure(options, "edge_torque_cone",
                 cone(slide.torques, kAcross, "Torques at the edge", "N m"));
  for (const auto& [name, normals] : slide.normals) {
    std::vector<Eigen::Vector3d> n;
    for (const auto& normal : normals.sensed) n.push_back(normal.n);
    publish_figure(options, "edge_normals_" + name,
                   cone(n, kAcross, "Normals at the edge, " + name, "1"));
  }
}

std::string face_list(const std::vector<tactile::Face>& faces,
                      const std::vector<Eigen::Vector3d>& truth) {
  std::string text;
  for (const auto& face : faces) {
    text += fmt::format("{}({:.2f}, {:.2f}, {:.2f}) {:.0f} %", text.empty() ? "" : "; ", face.n.x(),
                        face.n.y(), face.n.z(), 100 * face.share);
    if (truth.empty()) continue;
    double error = 180;
    for (const auto& n : truth) error = std::min(error, tactile::angle_between_deg(face.n, n));
    text += fmt::format(", {:.1f} deg off", error);
  }
  return text;
}

/// The finger's errors on its way over the surface.
Slide slide_over(const TouchedSurface& surface, const Options& options) {
  SlidingFinger finger(surface.object, sliding_world(), options.seed,
                       straight_finger(hand::FingerName::first));
  SlideErrors errors(finger.believed_hand());
  const auto path = path_over(surface, finger.tip_radius(), options.quick ? 4 : 100);
  for (const auto& tick : finger.follow(path, surface.start, kPress)) errors.take(tick);
  return errors.finish();
}

std::vector<std::string> error_row(const std::string& name, Slide& slide) {
  std::vector<std::string> row = {name, std::to_string(slide.samples),
                                  std::to_string(slide.flagged)};
  for (const std::string kind : {"raw", "clustered", "s2", "s2-lag"}) {
    const auto& of_kind = slide.normals[kind].error_deg;
    row.push_back(of_kind.empty()
                      ? "-"
                      : fmt::format("{:.2f} / {:.1f}", median(of_kind), quantile(of_kind, 0.95)));
  }
  return row;
}

void experiment_surfaces(const Options& options) {
  Table errors({"surface", "samples", "flagged", "raw", "clustered", "s2", "s2-lag"});
  Table honesty({"surface", "s2", "s2-lag"});
  Table faces(
      {"surface", "faces crossed", "faces found by s2-lag: normal, share of the time, error"});
  std::map<std::string, plotting::Plot> densities;
  for (const std::string name : {"flat", "edge", "smooth", "corner"}) {
    const auto surface = touched_surface(name);
    Slide slide = slide_over(surface, options);
    errors.add_row(error_row(name, slide));
    honesty.add_row({name, fmt::format("{:.2f}", mean(slide.normals["s2"].nees)),
                     fmt::format("{:.2f}", mean(slide.normals["s2-lag"].nees))});
    faces.add_row({name, std::to_string(surface.faces.size()),
                   face_list(tactile::find_faces(slide.normals["s2-lag"].sensed), surface.faces)});
    for (const auto& [kind, normals] : slide.normals) {
      densities[kind].series.emplace_back(density(name, normals.error_deg));
    }
    if (name == "edge") draw_edge(slide, options);
  }
  errors.publish(options, "errors", "Angle error against the surface met, median / p95 deg");
  honesty.publish(options, "nees", "Normalised error squared, mean (honest: 2)");
  faces.publish(options, "faces", "Faces reported");
  for (auto& [kind, plot] : densities) {
    plot.title = fmt::format("P(angle error) of the sensed normals, {}", kind);
    plot.x.label = "angle error (deg)";
    plot.y.label = "share a degree";
    publish_figure(options, "angle_error_" + kind, plotting::to_svg(plot));
  }
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "touch_surfaces",
             "The simulated index finger slides for 100 s over a flat face, an edge, a smooth "
             "surface and a corner (thesis figures 5.12-5.15)",
             experiment_surfaces);
}
