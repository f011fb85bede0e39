// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "palpate/numerics/mlp.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

/// What a policy may act on: one frame, no history, no time.
struct PolicyInput {
  RelocateObservation observation;
  Proprioception proprioception;  ///< a memoryless policy does not look at it
};

/// A policy as plain data, which is what its file holds.
struct PolicyRecord {
  std::string kind;                                   ///< "mlp" or "structured"
  std::vector<int> sizes;                             ///< layers of its network; may be empty
  std::map<std::string, std::vector<double>> arrays;  ///< all else
  std::map<std::string, std::string> notes;           ///< how it was made: command, seed, ...
};

/// Chooses actions for the relocate task.
class Policy {
 public:
  virtual ~Policy() = default;

  /// The mean action; the task clips it to -1..1.
  virtual RelocateAction act(const PolicyInput& input) const = 0;

  /// What of its input it looks at: "joint_positions", "object_position", "target_position",
  /// "base_velocity".
  virtual std::vector<std::string> observes() const;

  /// What there is to know about it; policy_from() makes the same policy of it.
  virtual PolicyRecord record() const = 0;
};

/// A network on the 39 observations, its inputs and outputs normalised:
/// action = output_shift + output_scale * network((observation - shift) / scale).
class MlpPolicy : public Policy {
 public:
  struct Normalization {
    Eigen::VectorXd input_shift, input_scale;    ///< 39
    Eigen::VectorXd output_shift, output_scale;  ///< 30
  };

  /// @param log_std  of the actions while exploring, 30
  /// @throws BadInput unless the network is 39 -> ... -> 30 and the normalisation fits it
  MlpPolicy(numerics::Mlp network, Normalization normalization, Eigen::VectorXd log_std);

  RelocateAction act(const PolicyInput& input) const override;
  PolicyRecord record() const override;

  /// Mean actions (30 x n) of observations (39 x n).
  Eigen::MatrixXd mean(const Eigen::MatrixXd& observations) const;
  Eigen::MatrixXd normalized(const Eigen::MatrixXd& observations) const;

  const numerics::Mlp& network() const { return network_; }
  numerics::Mlp& network() { return network_; }
  const Normalization& normalization() const { return normalization_; }
  const Eigen::VectorXd& log_std() const { return log_std_; }
  void set_log_std(const Eigen::VectorXd& log_std) { log_std_ = log_std; }

 private:
  numerics::Mlp network_;
  Normalization normalization_;
  Eigen::VectorXd log_std_;
};

/// Normalisation that leaves everything as it is.
MlpPolicy::Normalization no_normalization();

/// The policy that a record describes.
/// @throws BadInput for an unknown kind, a missing, unknown or wrongly sized array, or a value that
///         is not finite
std::unique_ptr<Policy> policy_from(const PolicyRecord& record);

}  // namespace palpate::relocate
