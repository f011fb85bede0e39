// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "palpate/tasks/relocate/training/trainer.hpp"
#include "tasks/relocate/policies/policy_record.hpp"
#include "tasks/relocate/training/mlp_checkpoint.hpp"

namespace palpate::relocate {
namespace {

class NpgTrainer : public Trainer {
 public:
  NpgTrainer(const TrainingContext& context, const NpgOptions& options, const MlpPolicy& from,
             Demonstrations demonstrations)
      : context_(context), options_(options), demonstrations_(std::move(demonstrations)) {
    check(demonstrations_);
    state_.policy = from.record();
  }

  Metrics iterate() override {
    const auto result = npg_iteration(state_, context_.model, options_, demonstrations_,
                                      context_.seed, context_.threads);
    const auto evaluation = evaluate();
    return {{"evaluation", evaluation.mean},
            {"evaluation_5cm", evaluation.success_5cm},
            {"return", result.mean_return},
            {"success_5cm", result.success_5cm},
            {"surrogate_gain", result.surrogate_gain},
            {"divergence", result.divergence},
            {"value_explained", result.explained}};
  }

  int iteration() const override { return state_.iteration; }
  PolicyRecord policy() const override { return state_.policy; }

  void save(learning::Checkpoint& checkpoint) const override {
    save_mlp(state_.policy, checkpoint);
    if (!state_.value) return;
    checkpoint.arrays["value_parameters"] = state_.value->parameters();
    checkpoint.arrays["value_range"] = Eigen::Vector2d(state_.value_shift, state_.value_scale);
    checkpoint.arrays["value_sizes"] =
        Eigen::VectorXi::Map(state_.value->sizes().data(), std::ssize(state_.value->sizes()))
            .cast<double>();
  }

  void restore(const learning::Checkpoint& checkpoint) override {
    state_.iteration = checkpoint.iteration;
    state_.policy = restore_mlp(checkpoint);
    state_.value.reset();
    if (!checkpoint.arrays.contains("value_sizes")) return;
    const auto sizes = layer_sizes(checkpoint.array("value_sizes").reshaped());
    state_.value.emplace(sizes, numerics::Activation::relu, checkpoint.column("value_parameters"));
    const Eigen::VectorXd range = checkpoint.column("value_range", 2);
    state_.value_shift = range[0];
    state_.value_scale = range[1];
  }

 private:
  /// The mean action on starts of their own, the same after every iteration.
  RolloutSummary evaluate() const {
    const auto seed = RandomStream(context_.seed, "evaluation").bits();
    return summarize(rollout(context_.model, *policy_from(state_.policy), options_.episode, seed,
                             static_cast<std::size_t>(options_.evaluation), context_.threads));
  }

  TrainingContext context_;
  NpgOptions options_;
  Demonstrations demonstrations_;
  NpgState state_;
};

}  // namespace

std::unique_ptr<Trainer> make_npg_trainer(const TrainingContext& context, const NpgOptions& options,
                                          const MlpPolicy& from, Demonstrations demonstrations) {
  return std::make_unique<NpgTrainer>(context, options, from, std::move(demonstrations));
}

}  // namespace palpate::relocate
