// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "experiment.hpp"
#include "hand_scene.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/skills/pick.hpp"

namespace {

using namespace palpate;
using namespace palpate::estimation;
using namespace palpate::evaluation;
using namespace palpate::grasping;
using namespace palpate::skills;
using experiment::between;
using experiment::HandScene;
using experiment::Motion;

constexpr double kPlaceSigma = 0.0015;  // m, of the resting pose that the hand is given
constexpr double kTurnSigma = 0.015;    // rad
constexpr double kTouch = 0.02;         // N
constexpr double kLifted = 0.05;        // m
constexpr double kGravity = 9.81;       // m/s^2
constexpr double kDegrees = 180 / std::numbers::pi;

/// The true resting pose with the error that touches leave: as if explored, in no time.
localization::Posterior reported_pose(const Eigen::Isometry3d& truth, std::uint64_t seed) {
  RandomStream random(seed, "told pose");
  const auto draw = [&](double sigma) {
    return Eigen::Vector3d(sigma * random.normal(), sigma * random.normal(),
                           sigma * random.normal());
  };
  localization::Mode mode;
  mode.T_frame_object = truth;
  mode.T_frame_object.linear() = exp_so3(draw(kTurnSigma)) * truth.linear();
  mode.T_frame_object.translation() += draw(kPlaceSigma);
  mode.weight = 1;
  mode.covariance.diagonal() << Eigen::Vector3d::Constant(kTurnSigma * kTurnSigma),
      Eigen::Vector3d::Constant(kPlaceSigma * kPlaceSigma);
  localization::Posterior posterior;
  posterior.modes.push_back(mode);
  return posterior;
}

int pressing_fingers(const hand::HandReading& reading) {
  int count = 0;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger)
    count += hand::tip_force(reading, finger) > kTouch;
  return count;
}

struct Grasp {
  bool lifted = false;
  int closed = 0, held = 0;  // fingers that touch
  Motion pressing, lifting;
  std::string outcome;
};

Grasp grasp_and_lift(const geometry::ObjectModel& model, std::uint64_t seed) {
  const PickOptions options;
  HandScene scene(model.object(), seed);
  PickState state;
  scene.robot().wait(hand::kTick);
  state.resting = reported_pose(scene.in_world(scene.now()), seed);
  GraspPhase grasp(options.grasp, model);
  Grasp result;
  result.outcome = run_phase(grasp, scene.robot(), state).outcome;
  const std::size_t closed = *scene.robot().log().at(TouchEvent::closed), pressed = scene.now();
  result.closed = pressing_fingers(scene.robot().log().readings[closed]);
  result.pressing = between(scene.in_hand(closed), scene.in_hand(pressed));
  LiftPhase lift(options.lift, model.object().mass * kGravity);
  run_phase(lift, scene.robot(), state);
  result.held = pressing_fingers(scene.robot().reading());
  result.lifting = between(scene.in_hand(pressed), scene.in_hand(scene.now()));
  result.lifted = scene.lowest() > kLifted;
  return result;
}

std::string median_p90(const std::vector<double>& values) {
  if (values.empty()) return "-";
  return fmt::format("{:.2f} / {:.2f}", median(values), quantile(values, 0.9));
}

void run(const experiment::Options& options) {
  const int trials = options.quick ? 1 : 20;
  const std::vector<std::string> names =
      options.quick ? std::vector<std::string>{"bracket"}
                    : std::vector<std::string>{"mug", "bottle", "box", "bracket", "bunny"};
  experiment::Table all({"object", "seed", "fingers closed", "held", "lifted", "pressing mm",
                         "pressing deg", "lifting mm", "lifting deg", "grasp"});
  experiment::Table summary({"object", "lifted", "fingers: mean", "closed with 4 or 5",
                             "pressing deg: median / p90", "lifting mm", "lifting deg",
                             "turned by less than 3 deg"});
  for (const std::string& name : names) {
    const geometry::ObjectModel model(geometry::load_known_object(name));
    std::vector<double> fingers, pressing, way, turn;
    int lifted = 0, many = 0, steady = 0;
    for (int i = 0; i < trials; ++i) {
      const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(i);
      const Grasp grasp = grasp_and_lift(model, seed);
      const double deg = kDegrees * grasp.lifting.turn;
      all.add_row({name, std::to_string(seed), std::to_string(grasp.closed),
                   std::to_string(grasp.held), grasp.lifted ? "yes" : "no",
                   fmt::format("{:.2f}", 1e3 * grasp.pressing.way),
                   fmt::format("{:.2f}", kDegrees * grasp.pressing.turn),
                   fmt::format("{:.2f}", 1e3 * grasp.lifting.way), fmt::format("{:.2f}", deg),
                   grasp.outcome});
      fingers.push_back(grasp.closed);
      many += grasp.closed >= 4;
      pressing.push_back(kDegrees * grasp.pressing.turn);
      if (!grasp.lifted) continue;
      ++lifted;
      steady += deg < 3;
      way.push_back(1e3 * grasp.lifting.way);
      turn.push_back(deg);
    }
    summary.add_row({name, fmt::format("{} of {}", lifted, trials),
                     fmt::format("{:.1f}", mean(fingers)), std::to_string(many),
                     median_p90(pressing), median_p90(way), median_p90(turn),
                     std::to_string(steady)});
  }
  all.publish(options, "grasps", "Every grasp");
  summary.publish(options, "grasp_hold", "How firmly the object is held");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "grasp_hold",
                         "How many fingers hold an object whose resting pose is nearly known, and "
                         "by how much pressing and lifting move it in the hand, by the truth",
                         run);
}
