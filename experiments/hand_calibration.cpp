// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "common/experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/random.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/explore/calibrate_phase.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace {

using namespace palpate;

constexpr int kPostures = 200;

/// Fingers closed each to its own share from the open hand of a grasp.
hand::JointVector random_grasp(RandomStream& random) {
  hand::ActuatorVector posture = hand::shadow_hand().postures.top.open;
  for (int i = 0; i < hand::kShadowActuators; ++i) {
    if (hand::shadow_hand().actuators[static_cast<std::size_t>(i)].finger < 0) continue;
    const auto name = hand::kShadowActuatorNames[static_cast<std::size_t>(i)];
    if (name.substr(2) == "J3") posture[i] += random.uniform(0, 1.0);
    if (name.substr(2) == "J0") posture[i] += random.uniform(0, 1.2);
    if (name == "THJ5" || name == "THJ2") posture[i] += random.uniform(0, 0.6);
  }
  return hand::joints_in_free_flexion(hand::shadow_hand(), posture);
}

Eigen::Vector3d tip(const hand::Description& hand, const hand::JointVector& joints,
                    std::size_t finger) {
  const auto T = hand::forward_kinematics(hand, joints);
  return T[static_cast<std::size_t>(hand.fingers[finger].link)] * hand.fingers[finger].tip.b;
}

/// Root mean square distance of fingertips in grasps from where they are, m.
double tip_error(const hand::Description& believed, const hand::Description& real) {
  RandomStream random(1, "postures");
  double sum = 0;
  for (int i = 0; i < kPostures; ++i) {
    const auto joints = random_grasp(random);
    for (std::size_t finger = 0; finger < hand::kShadowFingers; ++finger) {
      sum += (tip(believed, joints, finger) - tip(real, joints, finger)).squaredNorm();
    }
  }
  return std::sqrt(sum / (kPostures * hand::kShadowFingers));
}

double claimed_error(const hand::Description& hand) {
  double sum = 0;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    sum += 3 * std::pow(tactile::link_offset_sigma(hand, finger), 2);
  }
  return std::sqrt(sum / hand::kShadowFingers);
}

struct Sums {
  double before = 0, after = 0, claimed = 0, seconds = 0, wall = 0;
  std::string outcome;
};

void calibrate(const geometry::KnownObject& object, int touches, std::uint64_t seed, Sums& sums) {
  simulation::World world(object, {}, seed);
  world.reset(evaluation::draw_start(object, {}, seed),
              evaluation::waiting_command(world.hand_model()));
  skills::Executor robot(world.hand(), world.hand_model(),
                         evaluation::waiting_command(world.hand_model()));
  const auto real = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  sums.before += std::pow(tip_error(robot.model(), real), 2);
  skills::CalibrateOptions options;
  options.touches = touches;
  skills::CalibratePhase phase(options);
  skills::PickState state;
  const auto report = run_phase(phase, robot, state);
  sums.after += std::pow(tip_error(robot.model(), real), 2);
  sums.claimed += std::pow(claimed_error(robot.model()), 2);
  sums.seconds += report.robot_seconds;
  sums.wall += report.wall_seconds;
  sums.outcome = report.outcome;
  if (world.diverged()) throw std::runtime_error(fmt::format("seed {}: the world diverged", seed));
}

void calibrate_hands(const experiment::Options& options) {
  const auto object = geometry::load_known_object("box");
  const int hands = options.quick ? 1 : 20;
  experiment::Table table({"touches of the table", "tips off before, mm", "after, mm",
                           "claimed, mm", "robot's s", "wall s", "of the last hand"});
  for (const int touches : options.quick ? std::vector{10} : std::vector{10, 20, 30, 40, 60}) {
    Sums sums;
    for (int i = 0; i < hands; ++i) {
      calibrate(object, touches, options.seed + static_cast<std::uint64_t>(i), sums);
    }
    const auto rms = [&](double sum) {
      return fmt::format("{:.2f}", 1e3 * std::sqrt(sum / hands));
    };
    table.add_row({std::to_string(touches), rms(sums.before), rms(sums.after), rms(sums.claimed),
                   fmt::format("{:.0f}", sums.seconds / hands),
                   fmt::format("{:.1f}", sums.wall / hands), sums.outcome});
  }
  table.publish(options, "hand_calibration",
                fmt::format("Fingertips of {} hands, rms over {} grasps", hands, kPostures));
}

}  // namespace

int main(int argc, char** argv) {
  return palpate::experiment::run(
      argc, argv, "hand_calibration",
      "How well the hand knows its fingertips before and after it has touched the bare table",
      calibrate_hands);
}
