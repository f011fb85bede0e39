// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/structured_policy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "tasks/relocate/policies/policy_record.hpp"
#include "tasks/relocate/policies/structured_layout.hpp"

namespace palpate::relocate {
namespace {

using Eigen::Vector3d;

// The base's actuators: force = kGain * control - kStiffness * position, N and m.
constexpr double kGain = 500, kStiffness = 200;
constexpr double kLargestFeature = 6;  // standard deviations

// Joints of the ring and little finger that remember the base's x, y and z.
constexpr std::array<Eigen::Index, kMemoryJoints> kMemory = {19, 20, 24};
// Joints whose mean is the hand's flexion: the two knuckles of the first and middle finger.
constexpr std::array<Eigen::Index, 4> kFlexion = {9, 10, 13, 14};

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

/// Fraction with a width that a search may have made tiny or negative.
double over(double value, double width, double least) {
  return value / std::max(least, std::abs(width));
}

/// World axes to those of the base's sliding joints.
Vector3d base_axes(const Vector3d& world) { return {-world.x(), world.z(), world.y()}; }

Vector3d palm_from_object(const RelocateObservation& o) { return o.segment<3>(kPalmFromObject); }
Vector3d object_from_target(const RelocateObservation& o) {
  return o.segment<3>(kObjectFromTarget);
}

}  // namespace

struct StructuredPolicy::Gates {
  double far = 0;    ///< 1 far from the object, 0 over it
  double close = 0;  ///< 0 open, 1 closing
  double carry = 0;  ///< 0 reaching, 1 carrying
};

Vector3d StructuredPolicy::Observer::velocity(const Eigen::VectorXd& features) const {
  const Eigen::VectorXd x = (features - shift).cwiseQuotient(scale);
  return network(x.cwiseMax(-kLargestFeature).cwiseMin(kLargestFeature));
}

StructuredPolicy::StructuredPolicy(const StructuredParameters& parameters,
                                   const RelocateAction& center, const RelocateAction& half_range,
                                   bool with_memory, std::optional<Observer> observer)
    : parameters_(parameters),
      center_(center),
      half_range_(half_range),
      with_memory_(with_memory),
      observer_(std::move(observer)) {
  if (!flatten(parameters).allFinite() || !center.allFinite() || !half_range.allFinite()) {
    throw BadInput("a structured policy with parameters that are not finite");
  }
  if (!(half_range.minCoeff() > 0)) {
    throw BadInput(fmt::format("half_range must be positive, not {}", half_range.minCoeff()));
  }
  if (observer_ &&
      (observer_->network.sizes().front() != kFeatures || observer_->network.sizes().back() != 3 ||
       observer_->shift.size() != kFeatures || observer_->scale.size() != kFeatures ||
       !(observer_->scale.minCoeff() > 0))) {
    throw BadInput(fmt::format("a velocity observer of {} inputs and {} outputs, not {} and 3",
                               observer_->network.sizes().front(),
                               observer_->network.sizes().back(), kFeatures));
  }
}

StructuredPolicy::Gates StructuredPolicy::gates(const RelocateObservation& o) const {
  const auto& p = parameters_;
  const Vector3d away = palm_from_object(o) - p.grasp_offset;
  const double distance = away.norm();
  const double descending = Eigen::Vector2d(p.align[0] * away.x(), away.y()).norm();
  const double closing = Vector3d(p.align[1] * away.x(), away.y(), away.z()).norm();
  double flexion = 0;
  for (const Eigen::Index joint : kFlexion) flexion += o[joint] / std::ssize(kFlexion);
  Gates gates;
  gates.far = std::clamp(over(descending - p.descend[0], p.descend[1], 1e-3), 0.0, 1.0);
  gates.close =
      sigmoid(over(p.close[0] - closing, p.close[1], 1e-3) + p.latch[0] * (flexion - p.latch[1]));
  gates.carry = sigmoid(over(flexion - p.carry_flexion[0], p.carry_flexion[1], 1e-2)) *
                sigmoid(over(p.carry_distance[0] - distance, p.carry_distance[1], 2e-3));
  return gates;
}

Vector3d StructuredPolicy::memory(const RelocateObservation& o) const {
  const Vector3d position = o.head<3>() - parameters_.memory_center;
  return parameters_.memory_gain.cwiseProduct(position).cwiseMax(-1).cwiseMin(1);
}

Eigen::VectorXd StructuredPolicy::features(const RelocateObservation& o, const Gates& g) const {
  const Vector3d remembered = memory(o);
  Vector3d lag;
  for (std::size_t i = 0; i < kMemory.size(); ++i) {
    const Eigen::Index joint = kMemory[i], k = static_cast<Eigen::Index>(i);
    lag[k] = center_[joint] + half_range_[joint] * remembered[k] - o[joint];
  }
  Eigen::VectorXd result(kFeatures);
  result << o, g.close, g.carry, g.close * g.close, g.carry * g.carry, lag, g.carry * lag;
  return result;
}

Eigen::VectorXd StructuredPolicy::features(const RelocateObservation& observation) const {
  return features(observation, gates(observation));
}

Vector3d StructuredPolicy::base_force(const RelocateObservation& o, const Gates& g,
                                      const Vector3d& velocity) const {
  const auto& p = parameters_;
  const Vector3d offset = p.grasp_offset + g.far * (p.approach_offset - p.grasp_offset);
  const Vector3d reach = offset - palm_from_object(o);
  const Vector3d carry = p.target_offset - object_from_target(o);
  const double limit = std::abs(p.limits[0] + g.carry * (p.limits[1] - p.limits[0]));
  const Vector3d error = (reach + g.carry * (carry - reach)).cwiseMax(-limit).cwiseMin(limit);
  const Eigen::Vector2d gains = p.reach_gains + g.carry * (p.carry_gains - p.reach_gains);
  const Vector3d hold = p.reach_force + g.carry * (p.carry_force - p.reach_force);
  return gains[0] * base_axes(error) - gains[1] * velocity + hold;
}

RelocateAction StructuredPolicy::act(const PolicyInput& input) const {
  const auto& p = parameters_;
  const RelocateObservation& o = input.observation;
  const Gates g = gates(o);
  const Vector3d velocity = observer_ ? observer_->velocity(features(o, g))
                                      : Vector3d(input.proprioception.velocity.head<3>());
  const Vector3d control = (base_force(o, g, velocity) + kStiffness * o.head<3>()) / kGain;
  const Vector3d turn = p.grasp_turn + g.far * (p.approach_turn - p.grasp_turn);
  RelocateAction action;
  action.head<3>() = (control - center_.head<3>()).cwiseQuotient(half_range_.head<3>());
  action.segment<3>(3) = turn + g.carry * (p.carry_turn - turn);
  action.tail<24>() = p.open + g.close * (p.closed - p.open);
  if (with_memory_) {
    const Vector3d remembered = memory(o);
    for (std::size_t i = 0; i < kMemory.size(); ++i) {
      action[kMemory[i]] = remembered[static_cast<Eigen::Index>(i)];
    }
  }
  return action.cwiseMax(-1).cwiseMin(1);
}

std::vector<std::string> StructuredPolicy::observes() const {
  auto names = Policy::observes();
  if (!observer_) names.emplace_back("base_velocity");
  return names;
}

PolicyRecord StructuredPolicy::record() const {
  PolicyRecord record;
  record.kind = "structured";
  for_each_field(parameters_,
                 [&](const char* name, auto&& field) { record.arrays[name] = to_array(field); });
  record.arrays["action_center"] = to_array(center_);
  record.arrays["action_half_range"] = to_array(half_range_);
  record.arrays["with_memory"] = {with_memory_ ? 1.0 : 0.0};
  if (observer_) {
    record.sizes = observer_->network.sizes();
    record.arrays["observer_parameters"] = to_array(observer_->network.parameters());
    record.arrays["observer_shift"] = to_array(observer_->shift);
    record.arrays["observer_scale"] = to_array(observer_->scale);
  }
  return record;
}

namespace {

Eigen::VectorXd sized_array(const PolicyRecord& record, const std::string& name,
                            Eigen::Index size) {
  const Eigen::VectorXd values = array(record, name);
  if (values.size() != size) {
    throw BadInput(fmt::format("'{}' has {} values, not {}", name, values.size(), size));
  }
  return values;
}

std::optional<StructuredPolicy::Observer> observer_from(const PolicyRecord& record) {
  if (record.sizes.empty()) return {};
  return StructuredPolicy::Observer{
      numerics::Mlp(record.sizes, numerics::Activation::tanh, array(record, "observer_parameters")),
      array(record, "observer_shift"), array(record, "observer_scale")};
}

std::vector<std::string> array_names(bool with_observer) {
  std::vector<std::string> names = {"action_center", "action_half_range", "with_memory"};
  StructuredParameters parameters;
  for_each_field(parameters, [&](const char* name, auto&&) { names.emplace_back(name); });
  if (with_observer) {
    for (const char* name : {"observer_parameters", "observer_shift", "observer_scale"}) {
      names.emplace_back(name);
    }
  }
  return names;
}

}  // namespace

std::unique_ptr<Policy> structured_policy_from(const PolicyRecord& record) {
  check_arrays(record, array_names(!record.sizes.empty()));
  StructuredParameters parameters;
  for_each_field(parameters, [&](const char* name, auto&& field) {
    field = sized_array(record, name, field.size());
  });
  constexpr auto kJoints = kRelocateJoints;
  return std::make_unique<StructuredPolicy>(
      parameters, sized_array(record, "action_center", kJoints),
      sized_array(record, "action_half_range", kJoints),
      sized_array(record, "with_memory", 1)[0] != 0, observer_from(record));
}

}  // namespace palpate::relocate
