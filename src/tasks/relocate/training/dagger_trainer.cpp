// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/error.hpp"
#include "palpate/tasks/relocate/training/trainer.hpp"
#include "tasks/relocate/training/mlp_checkpoint.hpp"

namespace palpate::relocate {
namespace {

class DaggerTrainer : public Trainer {
 public:
  DaggerTrainer(const TrainingContext& context, const DaggerOptions& options, const Policy& expert)
      : context_(context), options_(options), expert_(expert) {}

  Metrics iterate() override {
    const auto round =
        dagger_round(state_, context_.model, expert_, options_, context_.seed, context_.threads);
    return {{"student_return", round.student_return}, {"action_error", round.error}};
  }

  int iteration() const override { return state_.round; }

  PolicyRecord policy() const override {
    if (!state_.student) throw BadInput("no policy yet: not one iteration is done");
    return *state_.student;
  }

  void save(learning::Checkpoint& checkpoint) const override {
    checkpoint.arrays["observations"] = state_.observations;
    checkpoint.arrays["actions"] = state_.actions;
    if (state_.student) save_mlp(*state_.student, checkpoint);
  }

  void restore(const learning::Checkpoint& checkpoint) override {
    state_.round = checkpoint.iteration;
    state_.observations = checkpoint.array("observations");
    state_.actions = checkpoint.array("actions");
    check_samples(state_.observations, state_.actions);
    state_.student.reset();
    if (state_.round > 0) state_.student = restore_mlp(checkpoint);
  }

 private:
  /// @throws BadInput unless they are the samples of a student, one a column
  static void check_samples(const Eigen::MatrixXd& observations, const Eigen::MatrixXd& actions) {
    const bool fit = observations.cols() == actions.cols() &&
                     (observations.cols() == 0 || (observations.rows() == kRelocateObservations &&
                                                   actions.rows() == kRelocateJoints));
    if (fit && observations.allFinite() && actions.allFinite()) return;
    throw BadInput(fmt::format("a checkpoint of {} x {} observations and {} x {} actions",
                               observations.rows(), observations.cols(), actions.rows(),
                               actions.cols()));
  }

  TrainingContext context_;
  DaggerOptions options_;
  const Policy& expert_;
  DaggerState state_;
};

}  // namespace

std::unique_ptr<Trainer> make_dagger_trainer(const TrainingContext& context,
                                             const DaggerOptions& options, const Policy& expert) {
  return std::make_unique<DaggerTrainer>(context, options, expert);
}

}  // namespace palpate::relocate
