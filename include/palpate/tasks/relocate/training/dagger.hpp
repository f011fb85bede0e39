// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

struct DaggerOptions {
  EpisodeOptions episode;
  int hidden = 64;              ///< units of each of two hidden layers
  int rounds = 10;              ///< of acting, asking the expert and fitting
  int episodes = 48;            ///< a round
  double expert_noise = 0.05;   ///< of the expert's actions while it shows the task
  double expert_share = 0.125;  ///< share of later rounds' episodes that the expert acts in
  int samples = 500000;         ///< to fit on in a round: its epochs times the frames
  double last_effort = 4;       ///< times as many in the last round
  double rate = 1.5e-3;         ///< of numerics::Adam

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("episode", episode);
    v("hidden", hidden, 1, 1024, "number of units in each of the two hidden layers");
    v("rounds", rounds, 1, 10000, "number of rounds of acting, asking the expert and fitting");
    v("episodes", episodes, 1, 100000, "number of episodes per round");
    v("expert_noise", expert_noise, 0.0, 2.0, "noise of the expert's actions in demonstrations");
    v("expert_share", expert_share, 0.0, 1.0,
      "share of the episodes of later rounds in which the expert acts");
    v("samples", samples, 1, 1000000000, "number of samples fitted per round");
    v("last_effort", last_effort, 1.0, 100.0, "factor on the samples of the last round");
    v("rate", rate, 1e-6, 1.0, "learning rate of Adam");
  }
};

/// What is kept between rounds; a checkpoint holds it.
struct DaggerState {
  int round = 0;
  Eigen::MatrixXd observations, actions;  ///< 39 x n, 30 x n: the frames met, the expert's answers
  std::optional<PolicyRecord> student;
};

struct DaggerRound {
  double student_return = 0;  ///< mean over the round's episodes that the student acted in
  double error = 0;           ///< mean squared, of an action
};

/// One round of dataset aggregation (Ross et al. 2011): the student acts, the expert says what it
/// would have done, the student learns from all frames so far. The expert acts in the first round.
/// The student is a network on the 39 observations alone; the expert may see more.
DaggerRound dagger_round(DaggerState& state, const RelocateModel& model, const Policy& expert,
                         const DaggerOptions& options, std::uint64_t seed, int threads);

}  // namespace palpate::relocate
