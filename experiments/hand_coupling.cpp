// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "experiment.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/world/world.hpp"

namespace {

using namespace palpate;

struct Waypoint {
  double middle, proximal;  // FFJ2, FFJ3, rad
};
constexpr std::array<Waypoint, 6> kPath = {
    {{0, 0}, {0.3, 0.5}, {0.9, 1.0}, {1.4, 0.6}, {0.6, 1.3}, {0, 0.2}}};  // a start and five
constexpr double kSeconds = 15;
constexpr hand::Coupling kCoupling;  // of the Shadow hand

/// Where the path is at `time`: at rest in every waypoint.
Waypoint on_path(double time) {
  const double at = std::clamp(time / kSeconds, 0.0, 1.0) * (kPath.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kPath.size() - 2);
  const double way = at - static_cast<double>(i);
  const double share = way * way * (3 - 2 * way);
  return {std::lerp(kPath[i].middle, kPath[i + 1].middle, share),
          std::lerp(kPath[i].proximal, kPath[i + 1].proximal, share)};
}

struct Trace {
  std::vector<double> time, j1, j2, j3, error_j2, error_j3;
};

Trace follow_path(std::uint64_t seed) {
  simulation::World world(geometry::load_known_object("box"), {}, seed);
  hand::HandCommand command;
  command.positions.setZero(hand::kShadowActuators);
  command.mount.xyz.z() = 0.5;
  world.reset({}, command);
  Trace trace;
  const int ticks = static_cast<int>(std::lround(kSeconds / hand::kTick));
  for (int tick = 1; tick <= ticks; ++tick) {
    const Waypoint target = on_path(tick * hand::kTick);
    command.positions[hand::shadow_hand().actuator("FFJ0")] =
        hand::j0_for_middle(target.middle, kCoupling);
    command.positions[hand::shadow_hand().actuator("FFJ3")] = target.proximal;
    world.hand().step(command);
    const hand::JointVector joints = world.truth().joints;
    trace.time.push_back(tick * hand::kTick);
    trace.j1.push_back(joints[hand::shadow_hand().joint("FFJ1")]);
    trace.j2.push_back(joints[hand::shadow_hand().joint("FFJ2")]);
    trace.j3.push_back(joints[hand::shadow_hand().joint("FFJ3")]);
    trace.error_j2.push_back(trace.j2.back() - target.middle);
    trace.error_j3.push_back(trace.j3.back() - target.proximal);
  }
  return trace;
}

double degrees(double angle) { return angle * 180 / std::numbers::pi; }

std::string cell(double angle) { return fmt::format("{:.1f}", degrees(angle)); }

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

void publish_waypoints(const experiment::Options& options, const Trace& trace) {
  experiment::Table table({"time s", "FFJ2 waypoint deg", "FFJ2 deg", "FFJ1 deg",
                           "FFJ1 in free flexion deg", "FFJ3 waypoint deg", "FFJ3 deg"});
  for (std::size_t i = 1; i < kPath.size(); ++i) {
    const std::size_t at = i * trace.time.size() / (kPath.size() - 1) - 1;
    const auto pair =
        hand::share_in_free_flexion(hand::j0_for_middle(trace.j2[at], kCoupling), kCoupling);
    table.add_row({fmt::format("{:.2f}", trace.time[at]), cell(kPath[i].middle), cell(trace.j2[at]),
                   cell(trace.j1[at]), cell(pair.j1), cell(kPath[i].proximal), cell(trace.j3[at])});
  }
  table.publish(options, "waypoints", "FFJ1 follows FFJ2: the joints at the waypoints");
}

void publish_summary(const experiment::Options& options, const Trace& trace) {
  double over = -1;
  for (std::size_t i = 0; i < trace.time.size(); ++i) {
    over = std::max(over, trace.j1[i] - trace.j2[i]);
  }
  experiment::Table table(
      {"FFJ1 above FFJ2 at most deg", "FFJ2 error rms deg", "FFJ3 error rms deg"});
  table.add_row(
      {cell(over), cell(root_mean_square(trace.error_j2)), cell(root_mean_square(trace.error_j3))});
  table.publish(options, "summary", "Over the whole path");
}

void publish_figure(const experiment::Options& options, const Trace& trace) {
  plotting::Plot plot;
  plot.title = "Joints of the first finger; no motion is commanded of FFJ1";
  plot.x.label = "time (s)";
  plot.x.low = 0;
  plot.x.high = kSeconds;
  plot.y.label = "angle (deg)";
  const auto line = [&](const std::string& name, const std::vector<double>& angles) {
    plotting::LineSeries series{.name = name, .x = trace.time, .y = angles};
    std::transform(angles.begin(), angles.end(), series.y.begin(), degrees);
    plot.series.emplace_back(series);
  };
  line("FFJ1", trace.j1);
  line("FFJ2", trace.j2);
  line("FFJ3", trace.j3);
  plotting::ScatterSeries middle{.name = "FFJ2 waypoints", .x = {}, .y = {}};
  plotting::ScatterSeries proximal{.name = "FFJ3 waypoints", .x = {}, .y = {}};
  for (std::size_t i = 1; i < kPath.size(); ++i) {
    const double time = kSeconds * static_cast<double>(i) / (kPath.size() - 1);
    middle.x.push_back(time);
    middle.y.push_back(degrees(kPath[i].middle));
    proximal.x.push_back(time);
    proximal.y.push_back(degrees(kPath[i].proximal));
  }
  plot.series.emplace_back(middle);
  plot.series.emplace_back(proximal);
  experiment::publish_figure(options, "figure_2_5", plotting::to_svg(plot));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "hand_coupling",
                         "Thesis figure 2.5: FFJ1 follows FFJ2 while FFJ2 and FFJ3 pass five "
                         "waypoints in 15 s.",
                         [](const experiment::Options& options) {
                           const Trace trace = follow_path(options.seed);
                           publish_waypoints(options, trace);
                           publish_summary(options, trace);
                           publish_figure(options, trace);
                         });
}
