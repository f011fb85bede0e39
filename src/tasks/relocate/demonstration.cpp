// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/demonstration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/simulation/hand/mjcf_hand.hpp"

namespace palpate::relocate {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kStep = 0.01;  // s, of the task
constexpr int kSettling = 40;   // steps until an object rests
constexpr int kBatch = 16;      // demonstrations between looks at how many succeeded
constexpr const char* kHand = "adroit_hand/adroit_relocate.xml";

/// Time at which the object has moved by `lifted` for the first time; none if never.
std::optional<double> lift_time(const std::vector<Eigen::Isometry3d>& poses, double rate,
                                double lifted) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if ((poses[i].translation() - poses.front().translation()).norm() > lifted) {
      return static_cast<double>(i) / rate;
    }
  }
  return {};
}

/// Joints of every frame, the robot's rest before them; times in `times`.
Eigen::MatrixXd place_frames(const std::vector<learning::HandKeypoints>& frames, double rate,
                             learning::Retargeter& retargeter, RelocateDynamics& dynamics,
                             const TranslationOptions& options, Eigen::VectorXd& times,
                             double& tip_error) {
  const Index count = std::ssize(frames);
  Eigen::MatrixXd joints(kRelocateJoints, count + 1);
  times.resize(count + 1);
  times[0] = 0;
  joints.col(0).setZero();
  retargeter.restart();
  for (Index i = 0; i < count; ++i) {
    const auto frame = retargeter.next(frames[static_cast<std::size_t>(i)]);
    joints.col(i + 1) = dynamics.place_palm(frame.T_world_root, frame.joints);
    times[i + 1] = options.lead + static_cast<double>(i) / rate;
    tip_error += frame.tip_error / static_cast<double>(count);
  }
  return joints;
}

/// The agent that follows a motion.
class Follower {
 public:
  Follower(const RobotMotion& motion, RelocateDynamics& dynamics, double mass,
           const Vector3d& target, const TranslationOptions& options)
      : motion_(motion), dynamics_(dynamics), mass_(mass), target_(target), options_(options) {}

  RelocateAction operator()(int step, const PolicyInput& input) const {
    const RelocateJoints q = motion_.joints.position.col(step);
    const RelocateJoints velocity = motion_.joints.velocity.col(step);
    const double held = motion_.held[step];
    const Vector3d object = target_ + input.observation.segment<3>(kObjectFromTarget);
    RelocateJoints forces =
        dynamics_.torques(q, velocity, motion_.joints.acceleration.col(step), held * mass_);
    forces += dynamics_.press(q, object, held * options_.press);
    forces.head<3>() += options_.stiffness * (q - input.observation.head<30>()).head<3>() +
                        options_.damping * (velocity - input.proprioception.velocity).head<3>();
    return dynamics_.action(q, velocity, forces).cwiseMax(-1).cwiseMin(1);
  }

 private:
  const RobotMotion& motion_;
  RelocateDynamics& dynamics_;
  double mass_;
  Vector3d target_;
  const TranslationOptions& options_;
};

/// Noise of each action that changes within a time, with the same spread at every step.
class ActionNoise {
 public:
  ActionNoise(const TranslationOptions& options, RandomStream random)
      : spread_(options.noise),
        kept_(options.noise_time > 0 ? std::exp(-kStep / options.noise_time) : 0),
        random_(std::move(random)) {
    value_ = drawn();
  }

  RelocateAction next() {
    const RelocateAction now = value_;
    value_ = kept_ * value_ + std::sqrt(1 - kept_ * kept_) * drawn();
    return now;
  }

 private:
  RelocateAction drawn() {
    if (spread_ == 0) return RelocateAction::Zero();
    return RelocateAction::NullaryExpr([&] { return spread_ * random_.normal(); });
  }

  double spread_, kept_;
  RandomStream random_;
  RelocateAction value_;
};

}  // namespace

RobotMotion translate(const learning::HumanSequence& sequence, learning::Retargeter& retargeter,
                      RelocateDynamics& dynamics, const TranslationOptions& options) {
  if (sequence.T_hand_object.size() < sequence.hand.size()) {
    throw BadInput(fmt::format("{} object poses of {} frames", sequence.T_hand_object.size(),
                               sequence.hand.size()));
  }
  const auto filtered = learning::filter_hand(sequence.hand, sequence.rate, options.filter);
  RobotMotion motion;
  Eigen::VectorXd times;
  const Eigen::MatrixXd joints = place_frames(filtered.hand, sequence.rate, retargeter, dynamics,
                                              options, times, motion.tip_error);
  motion.joints = learning::minimum_jerk(times, joints, options.smoothing, kStep);
  motion.joints.position =
      motion.joints.position.array()
          .min(dynamics.upper().replicate(1, motion.joints.position.cols()).array())
          .max(dynamics.lower().replicate(1, motion.joints.position.cols()).array());
  motion.held = Eigen::VectorXd::Zero(motion.joints.position.cols());
  const std::vector<Eigen::Isometry3d> poses(sequence.T_hand_object.begin() + options.filter.skip,
                                             sequence.T_hand_object.end());
  const auto lift = lift_time(poses, sequence.rate, options.lifted);
  for (Index i = 0; lift && i < motion.held.size(); ++i) {
    const double since = static_cast<double>(i) * kStep - (options.lead + *lift - options.squeeze);
    motion.held[i] = std::clamp(since / options.squeeze, 0.0, 1.0);
  }
  return motion;
}

Demonstration replay(const RelocateModel& model, const RobotMotion& motion,
                     RelocateDynamics& dynamics, const RelocateStart& start,
                     const TranslationOptions& options, RandomStream noise) {
  RelocateTask task(model);
  Demonstration result;
  result.start = start;
  const Follower follower(motion, dynamics, model.object_mass(), start.target, options);
  ActionNoise action_noise(options, std::move(noise));
  result.intended.resize(kRelocateJoints, motion.held.size());
  const Agent agent = [&](int step, const PolicyInput& input) -> RelocateAction {
    const RelocateAction action = follower(step, input);
    result.intended.col(step) = action;
    return (action + action_noise.next()).cwiseMax(-1).cwiseMin(1);
  };
  result.episode =
      run_episode(task, start, static_cast<int>(motion.held.size()), agent, &result.path);
  result.intended.conservativeResize(Eigen::NoChange, result.episode.steps);
  return result;
}

double rest_height(const RelocateModel& model) {
  RelocateTask task(model);
  const RelocateStart start{{0, 0.2}, {0, 0, 0}};
  task.reset(start);
  for (int i = 0; i < kSettling; ++i) task.step(RelocateAction::Zero());
  return task.observation()[38];
}

Demonstration synthetic_demonstration(const RelocateModel& model,
                                      const DemonstrationOptions& options, double rest_height,
                                      std::uint64_t seed, std::size_t index) {
  const auto start = episode_start(options.episode, seed, index);
  RandomStream random = RandomStream(seed, "synthetic human").fork("sequence", index);
  const Vector3d object(start.object.x(), start.object.y(), rest_height);
  const auto sequence = synthetic_relocation(object, start.target, options.human, random);
  learning::Retargeter retargeter(std::make_unique<simulation::MjcfHand>(asset(kHand), "palm"),
                                  learning::adroit_points(), options.translation.retarget);
  RelocateDynamics dynamics(model);
  const auto motion = translate(sequence, retargeter, dynamics, options.translation);
  Demonstration result =
      replay(model, motion, dynamics, start, options.translation, random.fork("actions"));
  result.index = index;
  return result;
}

DemonstrationSet make_demonstrations(const RelocateModel& model,
                                     const DemonstrationOptions& options, std::uint64_t seed,
                                     std::size_t count, std::size_t most, int threads,
                                     const ProgressCallback& progress) {
  const double height = rest_height(model);
  DemonstrationSet result;
  while (result.kept.size() < count && result.tried < most) {
    std::vector<Demonstration> batch(std::min<std::size_t>(kBatch, most - result.tried));
    parallel_for(batch.size(), threads, [&](std::size_t i) {
      batch[i] = synthetic_demonstration(model, options, height, seed, result.tried + i);
    });
    for (auto& demonstration : batch) {
      if (result.kept.size() == count) break;
      ++result.tried;
      const bool success = demonstration.episode.distance < options.translation.success;
      if (success) result.kept.push_back(std::move(demonstration));
    }
    if (progress) progress(result.kept.size(), count);
  }
  return result;
}

Demonstrations frames_of(const std::vector<Demonstration>& demonstrations) {
  Index count = 0;
  for (const auto& d : demonstrations) count += d.path.actions.cols();
  Demonstrations result;
  result.observations.resize(kRelocateObservations, count);
  result.actions.resize(kRelocateJoints, count);
  Index next = 0;
  for (const auto& d : demonstrations) {
    const Index steps = d.path.actions.cols();
    result.observations.middleCols(next, steps) = d.path.observations.leftCols(steps);
    result.actions.middleCols(next, steps) = d.intended;
    next += steps;
  }
  return result;
}

}  // namespace palpate::relocate
