// SPDX-License-Identifier: Apache-2.0
// Objects put into another stable pose by touch alone: over which stable poses, and how often it
// succeeds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/collision/forward_model.hpp"
#include "palpate/skills/place/regrasp.hpp"

namespace {

using namespace palpate;
using namespace palpate::estimation;
using namespace palpate::evaluation;
using namespace palpate::grasping;
using namespace palpate::skills;

constexpr double kSameStablePose = 5 * kDegree;
constexpr std::size_t kTrials = 20;

/// From the stable pose in which `from` of the object points up into that in which `to` does.
struct Change {
  std::string object, name;
  Eigen::Vector3d from, to;
};

struct Outcome {
  RegraspResult result;
  localization::PoseError error;  // from the target, modulo symmetry
  bool in_stable_pose = false;
  double robot_seconds = 0;
};

int stable_pose_with_up(const geometry::KnownObject& object, const Eigen::Vector3d& up) {
  const auto& stable_poses = object.stable_poses;
  const auto along = [&](const geometry::StablePose& s) { return s.R_table_object.row(2).dot(up); };
  const auto best =
      std::max_element(stable_poses.begin(), stable_poses.end(),
                       [&](const auto& a, const auto& b) { return along(a) < along(b); });
  return static_cast<int>(best - stable_poses.begin());
}

bool same_stable_pose(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b,
                      const std::vector<Eigen::Matrix3d>& symmetries) {
  return std::any_of(symmetries.begin(), symmetries.end(), [&](const Eigen::Matrix3d& S) {
    return std::acos(std::clamp((a * S).row(2).dot(b.row(2)), -1.0, 1.0)) < kSameStablePose;
  });
}

Outcome run_one(const geometry::ObjectModel& object, const Change& change, std::uint64_t seed) {
  const auto& known = object.object();
  TrialOptions options;
  options.start.stable_pose = stable_pose_with_up(known, change.from);
  simulation::World world(known, options.world, seed);
  world.reset(draw_start(known, options.start, seed), waiting_command(world.hand_model()));
  const simulation::SimulatedModels models;
  Executor robot(world.hand(), world.hand_model(), waiting_command(world.hand_model()), {},
                 &models);
  RandomStream random(seed, "target");
  PlaceTarget target{.kind = PlaceTarget::Kind::pose};
  target.T_world_object = resting_pose(
      known, static_cast<std::size_t>(stable_pose_with_up(known, change.to)),
      {random.uniform(0.1, 0.2), random.uniform(-0.1, 0.1)}, random.uniform(-M_PI, M_PI));
  Outcome outcome;
  outcome.result = regrasp(robot, {object, target, {}, options.pick, options.place, seed});
  robot.wait(0.5);
  const Eigen::Isometry3d truth = world.truth().T_world_object;
  outcome.error = localization::pose_error(truth, target.T_world_object, known.symmetries);
  outcome.in_stable_pose =
      same_stable_pose(truth.linear(), target.T_world_object.linear(), known.symmetries);
  outcome.robot_seconds = robot.time();
  return outcome;
}

void report(const Change& change, std::uint64_t seed, const Outcome& outcome) {
  fmt::print(stderr, "{} {}: {}, {} rounds, stable pose {}, {:.1f} deg, {:.1f} mm;", change.name,
             seed, to_string(outcome.result.status), outcome.result.rounds.size(),
             outcome.in_stable_pose ? "right" : "wrong", outcome.error.rotation / kDegree,
             1e3 * outcome.error.translation);
  for (const auto& round : outcome.result.rounds) {
    fmt::print(stderr, " [{} {}]", to_string(round.plan.strategy),
               round.place ? to_string(round.place->status) : "not held");
  }
  fmt::print(stderr, "\n");
}

std::string share(std::size_t count, std::size_t of) {
  const Interval interval = wilson_interval(count, of);
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]",
                     static_cast<double>(count) / static_cast<double>(of), interval.low,
                     interval.high);
}

std::vector<std::string> row_of(const Change& change, const std::vector<Outcome>& outcomes) {
  std::size_t changed = 0, placed = 0, done = 0;
  std::vector<double> rounds, plan_seconds, robot_seconds;
  std::map<std::string, int> ends;
  for (const Outcome& outcome : outcomes) {
    changed += outcome.in_stable_pose;
    placed += localization::within(outcome.error);
    done += outcome.result.status == RegraspStatus::done;
    rounds.push_back(static_cast<double>(outcome.result.rounds.size()));
    robot_seconds.push_back(outcome.robot_seconds);
    for (const auto& round : outcome.result.rounds) {
      plan_seconds.push_back(round.plan.seconds);
      ++ends[round.place ? std::string(to_string(round.place->status)) : "not held"];
    }
  }
  std::string all;
  for (const auto& [end, count] : ends) all += fmt::format("{} {}; ", end, count);
  return {change.name,
          fmt::format("{}", outcomes.size()),
          share(changed, outcomes.size()),
          share(placed, outcomes.size()),
          fmt::format("{}", done),
          fmt::format("{:.1f}", mean(rounds)),
          fmt::format("{:.2f}", median(plan_seconds)),
          fmt::format("{:.0f}", median(robot_seconds)),
          all};
}

void stable_poses(const experiment::Options& options) {
  const std::vector<Change> changes = {
      {"bottle", "lying bottle to standing", {0, 1, 0}, {0, 0, 1}},
      {"box", "lying box to standing", {1, 0, 0}, {0, 0, 1}},
      {"mug", "mug upside down to upright", {0, 0, -1}, {0, 0, 1}}};
  const std::size_t count = options.quick ? 1 : kTrials;
  experiment::Table table({"change of stable pose", "trials", "in the new stable pose",
                           "within 5 deg, 10 mm of the target", "thought done", "rounds",
                           "plan s (median)", "robot s (median)", "ends of rounds"});
  for (const Change& change : changes) {
    if (options.quick && change.object != "bottle") continue;
    const geometry::ObjectModel object(geometry::load_known_object(change.object));
    std::vector<Outcome> outcomes(count);
    parallel_ordered(
        count, options.threads,
        [&](std::size_t i) { return run_one(object, change, options.seed + i); },
        [&](std::size_t i, Outcome outcome) {
          report(change, options.seed + i, outcome);
          outcomes[i] = std::move(outcome);
        });
    table.add_row(row_of(change, outcomes));
  }
  table.publish(options, "stances", "Change of stable pose, the pose estimated by touch");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(
      argc, argv, "reorient_stable_poses",
      "Objects put into another stable pose by touch alone, over others if need be", stable_poses);
}
