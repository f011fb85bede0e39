// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <span>

#include "experiment.hpp"
#include "hand_scene.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "skills/grasp/pose_phase.hpp"

namespace {

using namespace palpate;
using namespace palpate::estimation;
using namespace palpate::evaluation;
using namespace palpate::grasping;
using namespace palpate::skills;
using experiment::between;
using experiment::Motion;
using Scene = experiment::HandScene;

constexpr double kExploreSeconds = 120;  // s of the robot's time that 16 contacts may take
constexpr std::size_t kExploreTouches = 16;
constexpr int kProbes = 9;             // as many as the phase has time for
constexpr double kElsewhere = 0.004;   // m between spots of a finger that are not the same
constexpr std::size_t kWindow = 15;    // readings of a touch that are averaged
constexpr double kHeldMotion = 0.010;  // m in the hand that a kept object moves in the lift
constexpr double kLifted = 0.05;       // m
constexpr double kGravity = 9.81;      // m/s^2
constexpr double kDegrees = 180 / std::numbers::pi;

struct Exploring {
  Motion motion;
  std::size_t contacts = 0;  // within the time allowed
};

Exploring explore(Scene& scene, PickState& state, const geometry::ObjectModel& model,
                  std::size_t touches, std::uint64_t seed) {
  const PickOptions defaults;
  ExploreOptions options = defaults.explore;
  options.touches = options.max_touches = static_cast<int>(touches);  // as pick --explore does
  const std::size_t first = scene.now();
  estimation::PoseEstimator estimator(model, defaults.estimation, seed);
  ExplorePhase phase(estimator, options);
  run_phase(phase, scene.robot(), state);
  Exploring result;
  result.motion = between(scene.in_world(first), scene.in_world(scene.now()));
  for (const std::size_t touch : scene.robot().log().all(TouchEvent::touched)) {
    result.contacts +=
        touch > first && static_cast<double>(touch - first) * hand::kTick < kExploreSeconds;
  }
  return result;
}

struct Probing {
  Motion motion;                // in the hand, from before the first touch to after the last
  std::vector<Motion> of_each;  // from before a touch until the finger is back
  std::vector<double> found;    // new contacts of each finger that probed, none included
  bool kept = false;            // and lifted
};

std::vector<tactile::Contact> contacts_at(const Executor& robot, std::size_t reading) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  return tactile::lasting_contacts(readings.subspan(reading + 1 - kWindow, kWindow), robot.model(),
                                   {});
}

/// The finger whose tip is farthest from where it was.
std::size_t moved_finger(const Executor& robot, std::size_t before, std::size_t after) {
  const auto& readings = robot.log().readings;
  const auto T_before = hand::forward_kinematics(robot.model(), readings[before].joints);
  const auto T_after = hand::forward_kinematics(robot.model(), readings[after].joints);
  std::size_t moved = 0;
  double farthest = 0;
  for (std::size_t finger = 0; finger < hand::kShadowFingers; ++finger) {
    const auto link = static_cast<std::size_t>(robot.model().fingers[finger].link);
    const Eigen::Vector3d& tip = robot.model().fingers[finger].tip.b;
    const double way = (T_after[link] * tip - T_before[link] * tip).norm();
    if (way <= farthest) continue;
    farthest = way;
    moved = finger;
  }
  return moved;
}

/// For each finger that probed, how many places it found that are away from all that it had before.
std::vector<double> new_contacts(const Executor& robot, const std::vector<std::size_t>& closed,
                                 const std::vector<std::size_t>& probes) {
  hand::PerFinger<std::vector<Eigen::Vector3d>> known;
  for (const auto& contact : contacts_at(robot, closed.front())) {
    known[static_cast<std::size_t>(contact.finger)].push_back(contact.p);
  }
  std::map<std::size_t, double> found;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const std::size_t finger = moved_finger(robot, closed[i], probes[i]);
    found.try_emplace(finger, 0);
    for (const auto& contact : contacts_at(robot, probes[i])) {
      if (contact.finger != static_cast<int>(finger)) continue;
      const bool is_new = std::none_of(
          known[finger].begin(), known[finger].end(),
          [&](const Eigen::Vector3d& p) { return (p - contact.p).norm() < kElsewhere; });
      if (!is_new) continue;
      known[finger].push_back(contact.p);
      ++found[finger];
    }
  }
  std::vector<double> counts;
  for (const auto& [finger, count] : found) counts.push_back(count);
  return counts;
}

bool lift(Scene& scene, PickState& state, double weight) {
  const Eigen::Isometry3d before = scene.in_hand(scene.now());
  LiftPhase phase({}, weight);
  run_phase(phase, scene.robot(), state);
  return scene.lowest() > kLifted && between(before, scene.in_hand(scene.now())).way < kHeldMotion;
}

/// Probes as often as it may, whether or not the pose is in doubt.
/// @return nothing if no pose was found in the closed hand
std::optional<Probing> probe(Scene& scene, PickState& state, const geometry::ObjectModel& model,
                             int most, std::uint64_t seed) {
  PickOptions options;
  options.palpation.max = most;
  options.palpation.regrasps = 0;
  options.palpation.certain = 1;
  options.palpation.min_gain_rate = 0;
  GraspPhase grasp(options.grasp, model);
  estimation::PoseEstimator estimator(model, options.estimation, seed);
  PosePhase estimate_closed(estimator, TouchEvent::closed);
  if (run_phase(grasp, scene.robot(), state).status != PhaseStatus::ok) return std::nullopt;
  if (run_phase(estimate_closed, scene.robot(), state).status != PhaseStatus::ok) {
    return std::nullopt;
  }
  const double weight = model.object().mass * kGravity;
  const std::size_t first = scene.now();
  PalpationPhase phase(estimator, options.palpation, options.grasp);
  run_phase(phase, scene.robot(), state);
  const auto closed = scene.robot().log().all(TouchEvent::closed);  // also after each touch
  const auto probes = scene.robot().log().all(TouchEvent::probed);
  Probing result;
  result.motion = between(scene.in_hand(first), scene.in_hand(scene.now()));
  for (std::size_t i = 0; i < probes.size(); ++i) {
    result.of_each.push_back(
        between(scene.in_hand(i == 0 ? first : closed[i]), scene.in_hand(closed[i + 1])));
  }
  result.found = new_contacts(scene.robot(), closed, probes);
  result.kept = lift(scene, state, weight);
  return result;
}

std::string median_p95(const std::vector<double>& values) {
  if (values.empty()) return "-";
  return fmt::format("{:.2f} / {:.2f}", median(values), quantile(values, 0.95));
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// All runs of an object.
struct Tally {
  std::vector<double> contacts, way_mm, turn_deg;                 // of exploring
  std::vector<double> found, each_mm, each_deg, all_mm, all_deg;  // of probing
  std::size_t touches = 0, probed = 0, kept = 0;

  void add(const Exploring& run) {
    contacts.push_back(static_cast<double>(run.contacts));
    way_mm.push_back(1e3 * run.motion.way);
    turn_deg.push_back(kDegrees * run.motion.turn);
  }
  void add(const Probing& run) {
    if (run.of_each.empty()) return;
    ++probed;
    kept += run.kept;
    touches += run.of_each.size();
    found.insert(found.end(), run.found.begin(), run.found.end());
    all_mm.push_back(1e3 * run.motion.way);
    all_deg.push_back(kDegrees * run.motion.turn);
    for (const Motion& motion : run.of_each) {
      each_mm.push_back(1e3 * motion.way);
      each_deg.push_back(kDegrees * motion.turn);
    }
  }
};

void run(const experiment::Options& options) {
  const int trials = options.quick ? 1 : 6;
  const std::size_t touches = options.quick ? 4 : kExploreTouches;
  const int probes = options.quick ? 1 : kProbes;
  const std::vector<std::string> names =
      options.quick ? std::vector<std::string>{"mug"}
                    : std::vector<std::string>{"mug", "bottle", "box", "bracket", "bunny"};
  experiment::Table explored({"object", "runs", "contacts in 120 s: median", "least",
                              "moved mm: median / p95", "turned deg: median / p95"});
  experiment::Table probed({"object", "runs probed", "touches", "new contacts", "a finger",
                            "a touch moves mm: median / p95", "turns deg", "all touches move mm",
                            "turn deg", "kept and lifted"});
  for (const std::string& name : names) {
    const geometry::ObjectModel model(geometry::load_known_object(name));
    Tally tally;
    for (int i = 0; i < trials; ++i) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
      Scene scene(model.object(), seed);
      PickState state;
      HeightProbePhase height_probe{HeightProbeOptions{}};
      if (run_phase(height_probe, scene.robot(), state).status != PhaseStatus::ok) continue;
      tally.add(explore(scene, state, model, touches, seed));
      if (const auto run = probe(scene, state, model, probes, seed)) tally.add(*run);
    }
    explored.add_row(
        {name, std::to_string(tally.contacts.size()),
         tally.contacts.empty() ? "-" : fmt::format("{:.0f}", median(tally.contacts)),
         tally.contacts.empty() ? "-" : fmt::format("{:.0f}", quantile(tally.contacts, 0)),
         median_p95(tally.way_mm), median_p95(tally.turn_deg)});
    probed.add_row({name, std::to_string(tally.probed), std::to_string(tally.touches),
                    fmt::format("{:.0f}", sum_of(tally.found)),
                    tally.found.empty() ? "-" : fmt::format("{:.1f}", mean(tally.found)),
                    median_p95(tally.each_mm), median_p95(tally.each_deg), median_p95(tally.all_mm),
                    median_p95(tally.all_deg), fmt::format("{} of {}", tally.kept, tally.probed)});
  }
  explored.publish(options, "exploring", "Touching the resting object 16 times");
  probed.publish(options, "probing", "Touching other spots of the held object");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "probing_and_exploring",
                         "How many contacts touching before the grasp and probing in it bring, and "
                         "by how much they move the object, by the simulator's truth",
                         run);
}
