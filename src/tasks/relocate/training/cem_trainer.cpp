// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/tasks/relocate/training/trainer.hpp"
#include "tasks/relocate/policies/policy_record.hpp"

namespace palpate::relocate {
namespace {

constexpr double kObserverRoom = 0.1;  // least spread, of the usual, once the observer takes over

class CemTrainer : public SearchTrainer {
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
    while (true) {
      const auto requests = ask();
      std::vector<Eigen::VectorXd> asked;
      for (const auto& request : requests) asked.push_back(parameters(request.candidate));
      if (const auto metrics = tell(run(requests, asked))) return *metrics;
    }
  }

  std::vector<RolloutRequest> ask() override {
    if (episodes_.empty()) {
      observer_r2_ = observer_due() ? refit() : 0;
      episodes_.resize(candidates().size());
    }
    return search_requests(episodes_, options_.search);
  }

  Eigen::VectorXd parameters(std::size_t candidate) const override {
    return candidates().at(candidate);
  }

  SearchEpisodes run(const std::vector<RolloutRequest>& requests,
                     const std::vector<Eigen::VectorXd>& parameters) const override {
    std::vector<StructuredPolicy> policies;
    for (const auto& x : parameters) policies.push_back(make_policy(x));
    return run_requests(context_.worlds, policies, requests, options_.search, context_.seed,
                        state_.generation, context_.threads);
  }

  std::optional<Metrics> tell(const SearchEpisodes& results) override {
    add_results(search_requests(episodes_, options_.search), results, episodes_);
    if (!search_requests(episodes_, options_.search).empty()) return std::nullopt;
    const auto generation = learning::cem_update(
        state_, candidates(), search_scores(episodes_, options_.search), options_.search.cem);
    episodes_.clear();
    return Metrics{
        {"best", generation.best}, {"elite", generation.elite}, {"observer_r2", observer_r2_}};
  }

  int iteration() const override { return state_.generation; }

  PolicyRecord policy() const override { return make_policy(state_.mean).record(); }

  void save(learning::Checkpoint& checkpoint) const override {
    checkpoint.arrays["mean"] = state_.mean;
    checkpoint.arrays["spread"] = state_.spread;
    if (!episodes_.empty()) checkpoint.arrays["under_way"] = under_way();
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
    state_.mean = checkpoint.column("mean", state_.mean.size());
    state_.spread = checkpoint.column("spread", state_.spread.size());
    episodes_.clear();
    if (checkpoint.arrays.contains("under_way")) go_on(checkpoint.array("under_way"));
    observer_.reset();
    if (!checkpoint.arrays.contains("observer_sizes")) return;
    observer_ = StructuredPolicy::Observer{
        numerics::Mlp(layer_sizes(checkpoint.array("observer_sizes").reshaped()),
                      numerics::Activation::tanh, checkpoint.column("observer_parameters")),
        checkpoint.column("observer_shift"), checkpoint.column("observer_scale")};
  }

 private:
  std::vector<Eigen::VectorXd> candidates() const {
    return learning::cem_candidates(state_, options_.search.cem, context_.seed);
  }

  /// The generation under way: a column an episode, behind one of the whole.
  Eigen::MatrixXd under_way() const {
    std::vector<std::array<double, 6>> columns = {
        {static_cast<double>(episodes_.size()), observer_r2_, 0, 0, 0, 0}};
    for (std::size_t i = 0; i < episodes_.size(); ++i) {
      for (const Episode& e : episodes_[i]) {
        columns.push_back({static_cast<double>(i), e.total, e.distance,
                           static_cast<double>(e.steps_within_5cm), static_cast<double>(e.steps),
                           e.diverged ? 1.0 : 0.0});
      }
    }
    Eigen::MatrixXd matrix(6, std::ssize(columns));
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
      matrix.col(k) = Eigen::VectorXd::Map(columns[static_cast<std::size_t>(k)].data(), 6);
    }
    return matrix;
  }

  void go_on(const Eigen::MatrixXd& matrix) {
    const auto population = static_cast<std::size_t>(options_.search.cem.population);
    if (matrix.rows() != 6 || matrix.cols() < 1 ||
        matrix(0, 0) != static_cast<double>(population)) {
      throw BadInput("the checkpoint's generation is not of this search");
    }
    observer_r2_ = matrix(1, 0);
    episodes_.resize(population);
    for (Eigen::Index k = 1; k < matrix.cols(); ++k) {
      const auto column = matrix.col(k);
      if (!(column[0] >= 0 && column[0] < matrix(0, 0))) {
        throw BadInput("the checkpoint has an episode of no candidate");
      }
      episodes_[static_cast<std::size_t>(column[0])].push_back(
          {column[1], column[2], static_cast<int>(column[3]), static_cast<int>(column[4]),
           column[5] != 0});
    }
  }

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
  SearchEpisodes episodes_;  // of the generation under way; none: it has not begun
  double observer_r2_ = 0;   // of its refit
  std::optional<StructuredPolicy::Observer> observer_;
};

}  // namespace

std::unique_ptr<SearchTrainer> make_cem_trainer(const TrainingContext& context,
                                                const CemTrainingOptions& options,
                                                const StructuredPolicy* from) {
  return std::make_unique<CemTrainer>(context, options, from);
}

}  // namespace palpate::relocate
