// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/simulation/world/world.hpp"

namespace {

using namespace palpate;
using experiment::Options;

constexpr double kSettling = 1;  // s
constexpr double kResting = 59;  // s, after it
constexpr double kStillDeg = 0.1, kStillMm = 0.1;
constexpr std::uint64_t kGenerated = 100;
constexpr std::size_t kMaxPoses = 24;
constexpr double kQuickTime = 1;  // s
constexpr double kHighAbove = 1;  // m, of the hand, which does not take part
constexpr double kDegrees = 180 / std::numbers::pi;

/// How far an object left alone moves in one stable pose.
struct Rest {
  double settled_deg = 0, settled_mm = 0;  ///< from its stable pose, after it settled
  double turned_deg = 0, moved_mm = 0;     ///< most, from where it had settled
};

Rest rest(const geometry::KnownObject& object, int pose, double seconds) {
  simulation::WorldOptions options;
  simulation::World world(object, options, 1);
  hand::HandCommand away;
  away.positions.setZero(world.hand_model().actuator_count());
  away.mount.xyz.z() = kHighAbove;
  world.reset({.stable_pose = pose, .yaw = 0.7}, away);
  const auto now = [&] { return world.truth().T_world_object; };
  Eigen::Isometry3d start = now();
  start.translation().z() = object.stable_poses[static_cast<std::size_t>(pose)].height;
  const auto distance_mm = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return 1e3 * (a.translation() - b.translation()).norm();
  };
  const auto angle_deg = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return kDegrees * rotation_distance(a.linear(), b.linear());
  };
  for (double t = 0; t < kSettling; t += hand::kTick) world.hand().step(away);
  const Eigen::Isometry3d settled = now();
  Rest result{.settled_deg = angle_deg(start, settled), .settled_mm = distance_mm(start, settled)};
  for (double t = 0; t < seconds; t += hand::kTick) {
    world.hand().step(away);
    result.turned_deg = std::max(result.turned_deg, angle_deg(settled, now()));
    result.moved_mm = std::max(result.moved_mm, distance_mm(settled, now()));
  }
  return result;
}

/// The built-in objects, generated ones, and the scans of the folder that PALPATE_DATA names.
std::vector<std::string> object_names(const Options& options) {
  if (options.quick) return {"bottle"};
  std::vector<std::string> names = geometry::built_in_objects();
  for (std::uint64_t i = 0; i < kGenerated; ++i) {
    names.push_back(fmt::format("generated:{}", options.seed + i));
  }
  const char* data = std::getenv("PALPATE_DATA");
  if (!data) return names;
  for (const auto& file :
       std::filesystem::directory_iterator(std::filesystem::path(data) / "ycb")) {
    if (file.path().extension() == ".ply") names.push_back(file.path().string());
  }
  std::ranges::sort(names);
  return names;
}

void rests(const Options& options) {
  experiment::Table table({"object", "stable poses", "settled deg", "settled mm", "turned deg",
                           "moved mm", "poses that rest"});
  std::size_t resting = 0, all = 0;
  for (const std::string& name : object_names(options)) {
    const auto object = geometry::load_known_object(name);
    const std::size_t poses = std::min(object.stable_poses.size(), options.quick ? 1 : kMaxPoses);
    std::vector<Rest> rests(poses);
    parallel_for(poses, options.threads, [&](std::size_t i) {
      rests[i] = rest(object, static_cast<int>(i), options.quick ? kQuickTime : kResting);
    });
    const auto most = [&](double Rest::*value) {
      const auto found = std::ranges::max_element(rests, {}, value);
      return fmt::format("{:.3f}", (*found).*value);
    };
    const auto held = static_cast<std::size_t>(std::ranges::count_if(
        rests, [](const Rest& r) { return r.turned_deg < kStillDeg && r.moved_mm < kStillMm; }));
    table.add_row({object.name, fmt::format("{}", poses), most(&Rest::settled_deg),
                   most(&Rest::settled_mm), most(&Rest::turned_deg), most(&Rest::moved_mm),
                   fmt::format("{}", held)});
    fmt::print(stderr, "{}: {} of {}\n", object.name, held, poses);
    resting += held;
    all += poses;
  }
  table.publish(options, "resting",
                fmt::format("{} of {} stable poses rest: within {} deg and {} mm of where they "
                            "settled, for {} s; worst of each object's poses",
                            resting, all, kStillDeg, kStillMm, kResting));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "resting",
                         "Objects left alone on the table in each of their stable poses", rests);
}
