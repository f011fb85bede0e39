// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/learning/training/checkpoint.hpp"
#include "palpate/tasks/relocate/policies/velocity_observer.hpp"
#include "palpate/tasks/relocate/training/dagger.hpp"
#include "palpate/tasks/relocate/training/npg.hpp"
#include "palpate/tasks/relocate/training/randomization.hpp"
#include "palpate/tasks/relocate/training/structured_search.hpp"

namespace palpate::relocate {

/// Figures of one iteration, for the learning curves; the same names in every iteration.
using Metrics = std::vector<std::pair<std::string, double>>;

/// A way to learn, one iteration at a time. What an iteration does depends only on the state and
/// the seed, so a training that was interrupted goes on as if it had not been.
class Trainer {
 public:
  virtual ~Trainer() = default;

  virtual Metrics iterate() = 0;
  virtual int iteration() const = 0;  ///< how many are done
  virtual PolicyRecord policy() const = 0;
  /// Adds what restore() needs.
  virtual void save(learning::Checkpoint& checkpoint) const = 0;
  virtual void restore(const learning::Checkpoint& checkpoint) = 0;
};

/// A trainer whose rollouts may be run elsewhere: who asks, runs what is asked for and reports the
/// results, until tell() ends the iteration, has done what iterate() does, bit for bit.
class SearchTrainer : public Trainer {
 public:
  /// Begins an iteration if none is under way. @return never empty
  virtual std::vector<RolloutRequest> ask() = 0;
  /// Of a candidate of the iteration under way.
  virtual Eigen::VectorXd parameters(std::size_t candidate) const = 0;
  /// @param parameters  of the candidate of each request
  virtual SearchEpisodes run(const std::vector<RolloutRequest>& requests,
                             const std::vector<Eigen::VectorXd>& parameters) const = 0;
  /// Takes the results of all that was asked for. @return figures, where that ends the iteration
  virtual std::optional<Metrics> tell(const SearchEpisodes& results) = 0;
};

/// What all trainers are given.
struct TrainingContext {
  RelocateModel model;
  std::uint64_t seed = 0;
  int threads = 1;
  std::vector<RelocateModel> worlds =
      {};  ///< that cem draws its episodes from; none: the model alone
};

struct CemTrainingOptions {
  PolicySearchOptions search;
  bool memoryless = false;  ///< end in a policy on the observations alone
  int settle = 10;          ///< generations that still read the velocity, if memoryless
  int refit = 4;            ///< generations after which the observer is fitted again
  double spread = 1;        ///< of the first generation, times the usual
  ObserverOptions observer;
  RandomizationOptions randomization;  ///< of TrainingContext::worlds

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("search", search);
    v("memoryless", memoryless, "end with a policy that uses the observations alone");
    v("settle", settle, 0, 100000,
      "number of generations that still read the velocity, if memoryless");
    v("refit", refit, 1, 100000, "number of generations after which the observer is fitted again");
    v("spread", spread, 0.001, 10.0, "spread of the first generation, relative to the default");
    v.section("observer", observer);
    v.section("randomization", randomization);
  }
};

/// Tunes a structured policy by the cross-entropy method.
/// @param from  where to start; none: structured_start()
std::unique_ptr<SearchTrainer> make_cem_trainer(const TrainingContext& context,
                                                const CemTrainingOptions& options,
                                                const StructuredPolicy* from = nullptr);

/// Distils an expert into a network on the observations alone. The expert must outlive the trainer.
std::unique_ptr<Trainer> make_dagger_trainer(const TrainingContext& context,
                                             const DaggerOptions& options, const Policy& expert);

/// Natural policy gradient, with demonstrations (DAPG) or without (NPG).
/// @param from  where to start; a network that copies the demonstrations, or a random one
std::unique_ptr<Trainer> make_npg_trainer(const TrainingContext& context, const NpgOptions& options,
                                          const MlpPolicy& from, Demonstrations demonstrations);

}  // namespace palpate::relocate
