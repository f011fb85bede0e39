// SPDX-License-Identifier: Apache-2.0
// Turning a held object by the fingers about an axis that is none of its symmetry.
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/collision/forward_model.hpp"
#include "palpate/skills/reorient/in_hand_reorientation.hpp"

namespace {

using namespace palpate;
using namespace palpate::estimation;
using namespace palpate::evaluation;
using namespace palpate::grasping;
using namespace palpate::skills;

constexpr double kAsked = 15 * kDegree;
constexpr double kNearAngle = 0.1, kNearWay = 0.01;  // rad, m: HandManipulateBlock's
constexpr double kDropped = 0.02;                    // m over the table
constexpr std::size_t kTrials = 20;

struct Outcome {
  bool held = false;  // by the pick; nothing below means anything without
  ReorientResult result;
  localization::PoseError error;  // of the truth from the true pose turned as asked
  double tracking_error = 0;      // rad, by which the tracked turn is off the true one
  bool dropped = false;
};

/// The same turn for the true and for the estimated pose, so that the estimate's error at the
/// start, which is the pick's, does not count.
Outcome run_one(const geometry::ObjectModel& object, std::uint64_t seed) {
  const TrialOptions trial;
  simulation::World world(object.object(), trial.world, seed);
  world.reset(draw_start(object.object(), trial.start, seed), waiting_command(world.hand_model()));
  const simulation::SimulatedModels models;
  Executor robot(world.hand(), world.hand_model(), waiting_command(world.hand_model()), {},
                 &models);
  const PickResult picked = pick(robot, object, trial.pick, seed);
  const auto& modes = picked.estimate.posterior.modes;
  Outcome outcome;
  outcome.held = picked.held && !modes.empty();
  if (!outcome.held) return outcome;

  const Eigen::Matrix3d turn = exp_so3(kAsked * RandomStream(seed, "axis").unit_vector());
  Eigen::Isometry3d goal = modes.front().T_frame_object;
  goal.linear() = turn * goal.linear();
  const Eigen::Isometry3d before = world.truth().T_world_object;
  outcome.result = reorient_in_hand(robot, object, picked.estimate.posterior, goal, {}, seed);
  robot.wait(1.0);
  const Eigen::Isometry3d after = world.truth().T_world_object;
  Eigen::Isometry3d wanted = before;
  wanted.linear() = turn * before.linear();
  outcome.error = localization::pose_error(after, wanted, {Eigen::Matrix3d::Identity()});
  const Eigen::Matrix3d tracked = outcome.result.posterior.modes.front().T_frame_object.linear() *
                                  modes.front().T_frame_object.linear().transpose();
  outcome.tracking_error = rotation_distance(tracked, after.linear() * before.linear().transpose());
  outcome.dropped = world.truth().lowest_point < kDropped;
  return outcome;
}

bool reached(const Outcome& outcome) {
  return outcome.held && outcome.error.rotation < kNearAngle &&
         outcome.error.translation < kNearWay;
}

void report(const std::string& object, std::uint64_t seed, const Outcome& outcome) {
  if (!outcome.held) {
    fmt::print(stderr, "{} {}: not held\n", object, seed);
    return;
  }
  fmt::print(stderr, "{} {}: {}, {:.1f} deg {:.1f} mm off, tracked {:.1f} deg off{}{}\n", object,
             seed, to_string(outcome.result.end), outcome.error.rotation / kDegree,
             1e3 * outcome.error.translation, outcome.tracking_error / kDegree,
             reached(outcome) ? ", right" : "", outcome.dropped ? ", dropped" : "");
}

std::string share(std::size_t count, std::size_t of) {
  if (of == 0) return "-";
  const Interval interval = wilson_interval(count, of);
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]",
                     static_cast<double>(count) / static_cast<double>(of), interval.low,
                     interval.high);
}

std::string median_of(const std::vector<double>& values, std::string_view format) {
  return values.empty() ? "-" : fmt::format(fmt::runtime(format), median(values));
}

std::vector<std::string> row_of(const std::string& object, const std::vector<Outcome>& outcomes) {
  std::size_t held = 0, right = 0, dropped = 0;
  std::vector<double> angles, ways, tracking, seconds, plan_seconds;
  std::map<std::string_view, int> ends;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.held) continue;
    ++held;
    right += reached(outcome);
    dropped += outcome.dropped;
    angles.push_back(outcome.error.rotation / kDegree);
    ways.push_back(1e3 * outcome.error.translation);
    tracking.push_back(outcome.tracking_error / kDegree);
    seconds.push_back(outcome.result.seconds);
    plan_seconds.push_back(outcome.result.plan_seconds);
    ++ends[to_string(outcome.result.end)];
  }
  std::string all;
  for (const auto& [end, count] : ends) all += fmt::format("{} {}; ", end, count);
  return {object,
          fmt::format("{}", held),
          share(right, held),
          share(dropped, held),
          median_of(angles, "{:.1f}"),
          median_of(ways, "{:.1f}"),
          median_of(tracking, "{:.1f}"),
          median_of(seconds, "{:.1f}"),
          median_of(plan_seconds, "{:.1f}"),
          all};
}

void fingers(const experiment::Options& options) {
  const auto names = options.quick ? std::vector<std::string>{"bracket"}
                                   : std::vector<std::string>{"box", "bracket", "mug"};
  const std::size_t count = options.quick ? 1 : kTrials;
  experiment::Table table({"object", "held", "within .1 rad, 1 cm", "dropped", "rotation error deg",
                           "way mm", "tracking error deg", "robot s", "planning s", "ends"});
  std::vector<geometry::ObjectModel> objects;
  for (const auto& name : names) objects.emplace_back(geometry::load_known_object(name));
  // The objects take turns, so that a run that is stopped has tried all of them alike.
  std::vector<std::vector<Outcome>> outcomes(names.size(), std::vector<Outcome>(count));
  parallel_ordered(
      count * names.size(), options.threads,
      [&](std::size_t k) {
        return run_one(objects[k % names.size()], options.seed + k / names.size());
      },
      [&](std::size_t k, Outcome outcome) {
        const std::size_t object = k % names.size(), trial = k / names.size();
        report(names[object], options.seed + trial, outcome);
        outcomes[object][trial] = std::move(outcome);
      });
  for (std::size_t i = 0; i < names.size(); ++i) table.add_row(row_of(names[i], outcomes[i]));
  table.publish(options, "fingers", "15 deg about a random axis, by the fingers (medians)");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "reorient_fingers", "Turning a held object by the fingers",
                         fingers);
}
