// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <limits>
#include <numbers>

#include "experiment.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"
#include "tactile/normals/rls.hpp"
#include "touch_surfaces.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kFinger = static_cast<int>(hand::FingerName::first);

/// A vector over time.
struct Series {
  std::vector<double> time;
  std::vector<Eigen::Vector3d> value;
};

std::string figure(const Series& series, const std::string& title, const std::string& label) {
  plotting::Plot plot;
  plot.title = title;
  plot.x.label = "time (s)";
  plot.y.label = label;
  for (int axis = 0; axis < 3; ++axis) {
    plotting::LineSeries line{.name = std::string(1, "xyz"[axis]), .x = series.time, .y = {}};
    for (const auto& v : series.value) line.y.push_back(v[axis]);
    plot.series.emplace_back(std::move(line));
  }
  return plotting::to_svg(plot);
}

/// Velocity of the contact through the thesis' rolling low-pass filter of 100 samples.
Series filtered_velocity(const std::vector<tactile::FingerSample>& samples) {
  tactile::RollingMean low_pass(100);
  Series series;
  const tactile::FingerSample* last = nullptr;
  for (const auto& sample : samples) {
    if (!sample.flags.usable()) continue;
    if (last) {
      series.time.push_back(sample.time);
      series.value.push_back(low_pass.add((sample.p - last->p) / (sample.time - last->time)));
    }
    last = &sample;
  }
  return series;
}

Series normals_by(tactile::NormalEstimator& estimator,
                  const std::vector<tactile::FingerSample>& samples) {
  Series series;
  for (const auto& sample : samples) {
    const auto estimate = estimator.update(sample);
    series.time.push_back(sample.time);
    series.value.push_back(estimate.status == tactile::NormalStatus::tracked
                               ? estimate.n
                               : Eigen::Vector3d(Eigen::Vector3d::Constant(kNan)));
  }
  return series;
}

std::string path_figure(const std::vector<tactile::FingerSample>& samples) {
  plotting::Plot plot;
  plot.title = "Contact path on the flat face";
  plot.x.label = "x (mm)";
  plot.y.label = "y (mm)";
  plot.width = plot.height = 520;
  plotting::LineSeries measured{.name = "measured", .x = {}, .y = {}},
      filtered{.name = "rolling mean of 100", .x = {}, .y = {}};
  tactile::RollingMean low_pass(100);
  for (const auto& sample : samples) {
    if (!sample.flags.usable()) continue;
    const Eigen::Vector3d mean = low_pass.add(sample.p);
    measured.x.push_back(1e3 * sample.p.x());
    measured.y.push_back(1e3 * sample.p.y());
    filtered.x.push_back(1e3 * mean.x());
    filtered.y.push_back(1e3 * mean.y());
  }
  plot.series = {std::move(measured), std::move(filtered)};
  return plotting::to_svg(plot);
}

/// Errors against the top face's normal, after a second of contact, deg.
std::vector<double> errors_of(const Series& normals) {
  std::vector<double> errors;
  double first = kNan;
  for (std::size_t i = 0; i < normals.time.size(); ++i) {
    const Eigen::Vector3d& n = normals.value[i];
    if (!n.allFinite()) continue;
    if (std::isnan(first)) first = normals.time[i];
    if (normals.time[i] < first + 1) continue;
    errors.push_back(180 / std::numbers::pi * std::atan2(n.head<2>().norm(), n.z()));
  }
  return errors;
}

void experiment_rls(const Options& options) {
  const auto surface = touched_surface("flat");
  SlidingFinger finger(surface.object, sliding_world(), options.seed,
                       straight_finger(hand::FingerName::first));
  const auto path = path_over(surface, finger.tip_radius(), options.quick ? 3 : 14);
  tactile::SampleMaker maker;
  std::vector<tactile::FingerSample> samples;
  for (const auto& tick : finger.follow(path, surface.start, kPress)) {
    samples.push_back(
        maker.next(tactile::finger_frame(tick.frame.reading, finger.believed_hand(), kFinger)));
  }
  publish_figure(options, "contact_path", path_figure(samples));
  publish_figure(options, "velocity",
                 figure(filtered_velocity(samples), "Velocity of the contact, rolling mean of 100",
                        "velocity (m/s)"));
  Table table({"estimator", "median deg", "p95 deg"});
  for (const std::string name : {"rls-literal", "rls", "s2", "s2-lag"}) {
    const auto normals = normals_by(*tactile::make_normal_estimator(name), samples);
    const auto errors = errors_of(normals);
    publish_figure(options, "normal_" + name,
                   figure(normals, "Normal of the flat face by " + name, "component"));
    if (errors.empty()) {
      table.add_row({name, "no estimate", "-"});
    } else {
      table.add_row({name, fmt::format("{:.2f}", median(errors)),
                     fmt::format("{:.2f}", quantile(errors, 0.95))});
    }
  }
  table.publish(options, "errors", "Angle error on the flat face, true normal (0, 0, 1)");
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "touch_rls",
             "The index finger slides on a flat face for 14 s; normals by recursive least squares "
             "(thesis figures 5.3b, 5.6, 5.7)",
             experiment_rls);
}
