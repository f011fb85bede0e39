// SPDX-License-Identifier: Apache-2.0
#include "skills/reorient/step_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/parallel.hpp"

namespace palpate::skills {
namespace {

constexpr double kTouching = 0.05;  // N
constexpr double kFallen = 0.010;   // m off the way that was asked for

/// @param asked  m, of the object
bool fallen(const RolloutOutcome& settled, const RolloutOutcome& end,
            const Eigen::Vector3d& asked) {
  const Eigen::Vector3d way =
      end.T_mount_object.translation() - settled.T_mount_object.translation();
  return settled.diverged || end.diverged || (way - asked).norm() > kFallen;
}

}  // namespace

hand::ActuatorVector targets_of(const Executor& robot, const GraspView& view,
                                const grasping::GraspMotion& motion) {
  std::vector<tactile::Contact> carrying = view.contacts;
  grasping::GraspMotion regaining = motion;
  for (const auto& contact : view.lost) {
    carrying.push_back(contact);
    regaining.press[static_cast<std::size_t>(contact.finger)] += view.regain;
  }
  hand::ActuatorVector targets =
      view.command.positions + view.lead +
      grasping::finger_motion(robot.model(), view.joints, carrying,
                              view.T_mount_object.translation(), regaining);
  for (Eigen::Index i = 0; i < targets.size(); ++i) {
    const auto& range = robot.actuators()[static_cast<std::size_t>(i)].command;
    targets[i] = std::clamp(targets[i], range.low, range.high);
  }
  return targets;
}

Vector6d way_between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  Vector6d way;
  way << log_so3(to.linear() * from.linear().transpose()), to.translation() - from.translation();
  return way;
}

StepSampler::StepSampler(const geometry::KnownObject& object, const Executor& robot,
                         const ReorientOptions& options, int threads)
    : robot_(robot), options_(options) {
  const int count = options.sampling.samples > 0 ? threads : 0;
  for (int i = 0; i < count; ++i) {
    models_.push_back(robot.models().forward_model(object, robot.model()));
  }
}

/// The first is the step itself.
std::vector<grasping::GraspMotion> StepSampler::variants(const Vector6d& step,
                                                         RandomStream& random) const {
  const SamplingOptions& sampling = options_.sampling;
  std::vector<grasping::GraspMotion> motions(static_cast<std::size_t>(sampling.samples),
                                             {step, {}});
  for (std::size_t i = 1; i < motions.size(); ++i) {
    motions[i].twist *= 1 + sampling.scale_sigma * random.normal();
    motions[i].twist.head<3>() += sampling.rotation_sigma * random.normal3();
    motions[i].twist.tail<3>() += sampling.translation_sigma * random.normal3();
    for (std::size_t k = 0; k < robot_.model().fingers.size(); ++k) {
      motions[i].press[k] = sampling.press_sigma * random.normal();
    }
  }
  return motions;
}

std::vector<hand::HandCommand> StepSampler::commands_of(const GraspView& view,
                                                        const grasping::GraspMotion& motion) const {
  const hand::ActuatorVector end = targets_of(robot_, view, motion);
  const auto moving = static_cast<int>(std::lround(options_.period / hand::kTick));
  const auto resting = static_cast<int>(std::lround(options_.pause / hand::kTick));
  std::vector<hand::HandCommand> commands;
  for (int i = 1; i <= moving + resting; ++i) {
    const double share = std::min(1.0, static_cast<double>(i) / moving);
    commands.push_back(view.command);
    commands.back().positions += share * (end - view.command.positions);
  }
  return commands;
}

double StepSampler::cost(const RolloutOutcome& settled, const RolloutOutcome& end,
                         const Vector6d& step) const {
  if (end.diverged) return std::numeric_limits<double>::infinity();
  const SamplingOptions& sampling = options_.sampling;
  const Vector6d miss = way_between(settled.T_mount_object, end.T_mount_object) - step;
  double sum = miss.head<3>().squaredNorm() / std::pow(sampling.angle_scale, 2) +
               miss.tail<3>().squaredNorm() / std::pow(sampling.distance_scale, 2);
  for (std::size_t finger = 0; finger < robot_.model().fingers.size(); ++finger) {
    const bool lost = settled.tip_forces[finger] > kTouching && end.tip_forces[finger] < kTouching;
    sum += lost ? sampling.finger_cost : 0;
  }
  return sum;
}

grasping::GraspMotion StepSampler::mix(const std::vector<grasping::GraspMotion>& motions,
                                       const std::vector<double>& costs) const {
  const double least = *std::min_element(costs.begin(), costs.end());
  if (!std::isfinite(least)) return motions.front();
  grasping::GraspMotion mean;
  double sum = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const double weight = std::exp((least - costs[i]) / options_.sampling.temperature);
    sum += weight;
    mean.twist += weight * motions[i].twist;
    for (std::size_t k = 0; k < mean.press.size(); ++k) {
      mean.press[k] += weight * motions[i].press[k];
    }
  }
  mean.twist /= sum;
  for (double& press : mean.press) press /= sum;
  return mean;
}

/// Each thread rolls out every so-many-th motion, all from the same start: what comes of a motion
/// does not depend on the number of threads.
ChosenStep StepSampler::choose(const GraspView& view, const Vector6d& step, RandomStream random) {
  if (options_.sampling.samples == 0) return {{step, {}}, std::nullopt, false};
  const auto motions = variants(step, random);
  std::vector<double> costs(motions.size());
  const BelievedGrasp grasp{view.command, view.joints,
                            view.command.mount.pose() * view.T_mount_object};
  const std::size_t threads = models_.size();
  parallel_for(threads, static_cast<int>(threads), [&](std::size_t thread) {
    ForwardModel& model = *models_[thread];
    const auto settled = model.settle(grasp, options_.sampling.settle);
    for (std::size_t i = thread; i < motions.size(); i += threads) {
      costs[i] = cost(settled, model.rollout(commands_of(view, motions[i])), step);
    }
  });
  rollouts_ += static_cast<int>(motions.size()) + 1;
  ChosenStep chosen{mix(motions, costs), std::nullopt, false};
  ForwardModel& model = *models_.front();
  const auto settled = model.settle(grasp, options_.sampling.settle);
  const auto end = model.rollout(commands_of(view, chosen.motion));
  chosen.falls = fallen(settled, end, chosen.motion.twist.tail<3>());
  if (chosen.falls) return chosen;
  chosen.displacement = end.T_mount_object * settled.T_mount_object.inverse();
  return chosen;
}

}  // namespace palpate::skills
