// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/policy.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/tasks/relocate/policies/structured_policy.hpp"
#include "tasks/relocate/policies/policy_record.hpp"

namespace palpate::relocate {
namespace {

void check_size(const char* name, const Eigen::VectorXd& values, Eigen::Index size) {
  if (values.size() != size) {
    throw BadInput(fmt::format("{} of {} values, not {}", name, values.size(), size));
  }
  if (!values.allFinite()) throw BadInput(fmt::format("{} holds a value that is not finite", name));
}

void check_scale(const char* name, const Eigen::VectorXd& values, Eigen::Index size) {
  check_size(name, values, size);
  if (values.minCoeff() <= 0) {
    throw BadInput(fmt::format("{} must be positive, not {}", name, values.minCoeff()));
  }
}

}  // namespace

std::vector<std::string> Policy::observes() const {
  return {"joint_positions", "object_position", "target_position"};
}

MlpPolicy::MlpPolicy(numerics::Mlp network, Normalization normalization, Eigen::VectorXd log_std)
    : network_(std::move(network)),
      normalization_(std::move(normalization)),
      log_std_(std::move(log_std)) {
  if (network_.sizes().front() != kRelocateObservations ||
      network_.sizes().back() != kRelocateJoints) {
    throw BadInput(fmt::format("a policy of {} inputs and {} outputs, not {} and {}",
                               network_.sizes().front(), network_.sizes().back(),
                               kRelocateObservations, kRelocateJoints));
  }
  check_size("input_shift", normalization_.input_shift, kRelocateObservations);
  check_scale("input_scale", normalization_.input_scale, kRelocateObservations);
  check_size("output_shift", normalization_.output_shift, kRelocateJoints);
  check_scale("output_scale", normalization_.output_scale, kRelocateJoints);
  check_size("log_std", log_std_, kRelocateJoints);
}

RelocateAction MlpPolicy::act(const PolicyInput& input) const { return mean(input.observation); }

Eigen::MatrixXd MlpPolicy::normalized(const Eigen::MatrixXd& observations) const {
  const auto& n = normalization_;
  return n.input_scale.cwiseInverse().asDiagonal() * (observations.colwise() - n.input_shift);
}

Eigen::MatrixXd MlpPolicy::mean(const Eigen::MatrixXd& observations) const {
  Eigen::MatrixXd result =
      normalization_.output_scale.asDiagonal() * network_(normalized(observations));
  return result.colwise() + normalization_.output_shift;
}

PolicyRecord MlpPolicy::record() const {
  PolicyRecord record;
  record.kind = "mlp";
  record.sizes = network_.sizes();
  record.arrays = {{"parameters", to_array(network_.parameters())},
                   {"input_shift", to_array(normalization_.input_shift)},
                   {"input_scale", to_array(normalization_.input_scale)},
                   {"output_shift", to_array(normalization_.output_shift)},
                   {"output_scale", to_array(normalization_.output_scale)},
                   {"log_std", to_array(log_std_)}};
  return record;
}

MlpPolicy::Normalization no_normalization() {
  return {Eigen::VectorXd::Zero(kRelocateObservations),
          Eigen::VectorXd::Ones(kRelocateObservations), Eigen::VectorXd::Zero(kRelocateJoints),
          Eigen::VectorXd::Ones(kRelocateJoints)};
}

namespace {

std::unique_ptr<Policy> mlp_policy_from(const PolicyRecord& record) {
  check_arrays(record, {"parameters", "input_shift", "input_scale", "output_shift", "output_scale",
                        "log_std"});
  return std::make_unique<MlpPolicy>(
      numerics::Mlp(record.sizes, numerics::Activation::tanh, array(record, "parameters")),
      MlpPolicy::Normalization{array(record, "input_shift"), array(record, "input_scale"),
                               array(record, "output_shift"), array(record, "output_scale")},
      array(record, "log_std"));
}

}  // namespace

std::unique_ptr<Policy> policy_from(const PolicyRecord& record) {
  if (record.kind == "mlp") return mlp_policy_from(record);
  if (record.kind == "structured") return structured_policy_from(record);
  throw BadInput(fmt::format("a policy of kind '{}': mlp or structured is known", record.kind));
}

}  // namespace palpate::relocate
