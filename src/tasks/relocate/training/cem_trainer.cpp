// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/tasks/relocate/training/trainer.hpp"
#include "tasks/relocate/policies/policy_record.hpp"

namespace palpate::relocate {
namespace {

constexpr double kObserverRoom = 0.1;  // least spread, of the usual, once the observer takes over

class CemTrainer : public Trainer {
 public:
  CemTrainer(const TrainingContext& context, const CemTrainingOptions& options,
             const StructuredPolicy* from)
      : context_(context), options_(options) {
    if (context_.worlds.empty()) context_.worlds = {context_.model};
    auto start = from ? from->parameters() : structured_start();
    if (options.memoryless && !(from && from->with_memory())) start = with_free_memory(start);
    state_.mean = flatten(start);
    state_.spread = options.spread * flatten(structured_spread());
    if (from && options.memoryless) observer_ = from->observer();
  }

  Metrics iterate() override {
    double r2 = 0;
    if (observer_due()) r2 = refit();
    const auto make = [this](const Eigen::VectorXd& x) { return make_policy(x); };
    const auto scores = search_scores(context_.worlds, make, options_.search, context_.seed,
                                      state_.generation, context_.threads);
    const auto generation =
        learning::cem_generation(state_, scores, options_.search.cem, context_.seed);
    return {{"best", generation.best}, {"elite", generation.elite}, {"observer_r2", r2}};
  }

  int iteration() const override { return state_.generation; }

  PolicyRecord policy() const override { return make_policy(state_.mean).record(); }

  void save(learning::Checkpoint& checkpoint) const override {
    checkpoint.arrays["mean"] = state_.mean;
    checkpoint.arrays["spread"] = state_.spread;
    if (!observer_) return;
    checkpoint.arrays["observer_sizes"] =
        Eigen::MatrixXd(Eigen::VectorXi::Map(observer_->network.sizes().data(),
                                             std::ssize(observer_->network.sizes()))
                            .cast<double>());
    checkpoint.arrays["observer_parameters"] = observer_->network.parameters();
    checkpoint.arrays["observer_shift"] = observer_->shift;
    checkpoint.arrays["observer_scale"] = observer_->scale;
  }

  void restore(const learning::Checkpoint& checkpoint) override {
    state_.generation = checkpoint.iteration;
    state_.mean = checkpoint.array("mean");
    state_.spread = checkpoint.array("spread");
    observer_.reset();
    if (!checkpoint.arrays.contains("observer_sizes")) return;
    observer_ = StructuredPolicy::Observer{
        numerics::Mlp(layer_sizes(checkpoint.array("observer_sizes").reshaped()),
                      numerics::Activation::tanh, checkpoint.array("observer_parameters")),
        checkpoint.array("observer_shift"), checkpoint.array("observer_scale")};
  }

 private:
  StructuredPolicy make_policy(const Eigen::VectorXd& parameters) const {
    return {unflatten(parameters), context_.model.action_center(),
            context_.model.action_half_range(), options_.memoryless, observer_};
  }

  bool observer_due() const {
    if (!options_.memoryless || state_.generation < options_.settle) return false;
    return !observer_ || (state_.generation - options_.settle) % options_.refit == 0;
  }

  double refit() {
    const bool first = !observer_;
    const auto fit = fit_observer(
        context_.worlds, make_policy(state_.mean), options_.search.episode, options_.observer,
        context_.seed + 31 * static_cast<std::uint64_t>(iteration()), context_.threads);
    observer_ = fit.observer;
    // What was tuned to the true velocity must be free to adapt to the observed one.
    if (first) {
      state_.spread = state_.spread.cwiseMax(kObserverRoom * flatten(structured_spread()));
    }
    return fit.r2;
  }

  TrainingContext context_;
  CemTrainingOptions options_;
  learning::CemState state_;
  std::optional<StructuredPolicy::Observer> observer_;
};

}  // namespace

std::unique_ptr<Trainer> make_cem_trainer(const TrainingContext& context,
                                          const CemTrainingOptions& options,
                                          const StructuredPolicy* from) {
  return std::make_unique<CemTrainer>(context, options, from);
}

}  // namespace palpate::relocate
