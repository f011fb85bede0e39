// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/dagger.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "learning/training/regression_data.hpp"
#include "palpate/core/parallel.hpp"

namespace palpate::relocate {
namespace {

constexpr double kMinScale = 0.01;
constexpr double kLogStd = -2.3;  // of a student that goes on to explore
constexpr int kMinEpochs = 4;

struct Lesson {
  learning::RegressionData data;
  Episode episode;
  bool student = false;
};

/// Who acts in an episode.
struct Actor {
  const Policy* student;  ///< null: the expert
  double noise;           ///< of the expert's actions
};

Lesson attend(const RelocateModel& model, const Policy& expert, const Actor& actor,
              const RelocateStart& start, const EpisodeOptions& options, RandomStream random) {
  RelocateTask task(model);
  Path path;
  Lesson lesson;
  Eigen::MatrixXd answers(kRelocateJoints, options.horizon);
  const Agent agent = [&](int step, const PolicyInput& input) {
    RelocateAction action = expert.act(input);
    answers.col(step) = action;
    if (actor.student) return actor.student->act(input);
    for (double& value : action) value += actor.noise * random.normal();
    return action;
  };
  lesson.episode = run_episode(task, start, options.horizon, agent, &path);
  lesson.student = actor.student != nullptr;
  const Eigen::Index steps =
      lesson.episode.diverged ? lesson.episode.steps - 1 : lesson.episode.steps;
  lesson.data = {path.observations.leftCols(steps), answers.leftCols(steps)};
  return lesson;
}

std::unique_ptr<MlpPolicy> new_student(const Eigen::MatrixXd& observations, int hidden,
                                       RandomStream& random) {
  auto normalization = no_normalization();
  std::tie(normalization.input_shift, normalization.input_scale) =
      learning::standardization(observations, kMinScale);
  numerics::Mlp network({kRelocateObservations, hidden, hidden, kRelocateJoints},
                        numerics::Activation::tanh, random);
  return std::make_unique<MlpPolicy>(std::move(network), normalization,
                                     Eigen::VectorXd::Constant(kRelocateJoints, kLogStd));
}

std::vector<Lesson> lessons(const DaggerState& state, const RelocateModel& model,
                            const Policy& expert, const DaggerOptions& options,
                            const RandomStream& random, std::uint64_t seed, int threads) {
  const auto student = state.student ? policy_from(*state.student) : nullptr;
  std::vector<Lesson> result(static_cast<std::size_t>(options.episodes));
  parallel_for(result.size(), threads, [&](std::size_t i) {
    RandomStream own = random.fork("episode", i);
    const bool shown = !student || own.uniform() < options.expert_share;
    const Actor actor{shown ? nullptr : student.get(), i % 2 == 0 ? 0.0 : options.expert_noise};
    const auto index = result.size() * static_cast<std::size_t>(state.round) + i;
    result[i] = attend(model, expert, actor, episode_start(options.episode, seed, index),
                       options.episode, own.fork("noise"));
  });
  return result;
}

double mean_student_return(const std::vector<Lesson>& all) {
  double sum = 0, count = 0;
  for (const Lesson& lesson : all) {
    if (!lesson.student) continue;
    sum += lesson.episode.total;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

DaggerRound dagger_round(DaggerState& state, const RelocateModel& model, const Policy& expert,
                         const DaggerOptions& options, std::uint64_t seed, int threads) {
  RandomStream random =
      RandomStream(seed, "dagger").fork("round", static_cast<std::uint64_t>(state.round));
  const auto all = lessons(state, model, expert, options, random, seed, threads);
  std::vector<learning::RegressionData> parts = {{state.observations, state.actions}};
  for (const Lesson& lesson : all) parts.push_back(lesson.data);
  auto data = learning::joined(parts);

  std::unique_ptr<Policy> known;
  if (state.student) known = policy_from(*state.student);
  std::unique_ptr<MlpPolicy> fresh;
  if (!known) fresh = new_student(data.inputs, options.hidden, random);
  MlpPolicy& student = known ? dynamic_cast<MlpPolicy&>(*known) : *fresh;

  numerics::RegressionOptions regression;
  const bool last = state.round + 1 == options.rounds;
  const double effort = last ? options.last_effort : 1;
  regression.epochs = std::max(
      kMinEpochs,
      static_cast<int>(effort * options.samples / static_cast<double>(data.inputs.cols())));
  regression.batch = 128;
  regression.rate = options.rate;
  const double error = numerics::fit_regression(student.network(), student.normalized(data.inputs),
                                                data.targets, regression, random);
  state.observations = std::move(data.inputs);
  state.actions = std::move(data.targets);
  state.student = student.record();
  ++state.round;
  return {mean_student_return(all), error};
}

}  // namespace palpate::relocate
