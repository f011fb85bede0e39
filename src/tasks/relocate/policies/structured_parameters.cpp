// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "tasks/relocate/policies/structured_layout.hpp"

namespace palpate::relocate {
namespace {

constexpr Eigen::Index kThumb = 19;  // first of its 5 in a posture
// What flexes ring and little finger, but for the joints that remember.
constexpr std::array<Eigen::Index, 4> kStretched = {11, 12, 16, 17};
constexpr double kStretchedOpen = -0.9, kStretchedClosed = -0.6;
constexpr std::array<Eigen::Index, 4> kSpreading = {2, 6, 10, 15};  // joints that spread fingers

/// A posture with one value for the wrist and what spreads fingers, one for what flexes them.
StructuredParameters::Posture posture(double spreading, double flexing, double thumb) {
  StructuredParameters::Posture result;
  result.setConstant(flexing);
  result.head<2>().setConstant(spreading);
  for (const Eigen::Index joint : kSpreading) result[joint] = spreading;
  result.tail<5>().setConstant(thumb);
  return result;
}

}  // namespace

StructuredParameters structured_start() {
  StructuredParameters start;
  start.open = posture(0, -0.6, 0);
  start.closed = posture(0, 0.4, 0);
  // The thumb stands against the fingers, open and closed.
  start.open.segment<2>(kThumb) << 0.8, -0.5;
  start.closed.segment<2>(kThumb) << 0.8, 0.2;
  return start;
}

StructuredParameters structured_spread() {
  StructuredParameters spread;
  for_each_field(spread, [](const char*, auto&& field) { field.setZero(); });
  spread.approach_offset.setConstant(0.03);
  spread.grasp_offset.setConstant(0.03);
  for (auto* turn : {&spread.approach_turn, &spread.grasp_turn, &spread.carry_turn}) {
    turn->setConstant(0.15);
  }
  spread.open.setConstant(0.35);
  spread.closed.setConstant(0.45);
  spread.open.head<2>().setConstant(0.2);
  spread.closed.head<2>().setConstant(0.2);
  spread.descend << 0.02, 0.015;
  spread.close << 0.03, 0.005;
  spread.latch << 3, 0.1;
  spread.align.setConstant(0.5);
  spread.carry_flexion << 0.12, 0.03;
  spread.carry_distance << 0.02, 0.004;
  spread.reach_gains << 250, 35;
  spread.carry_gains << 250, 35;
  spread.reach_force << 10, 8, 10;
  spread.carry_force << 10, 8, 10;
  spread.target_offset.setConstant(0.01);
  spread.limits.setConstant(0.1);
  spread.memory_gain << 1, 2, 1;
  spread.memory_center << 0.05, 0.03, 0.05;
  return spread;
}

StructuredParameters with_free_memory(StructuredParameters parameters) {
  for (const Eigen::Index joint : kStretched) {
    parameters.open[joint] = kStretchedOpen;
    parameters.closed[joint] = kStretchedClosed;
  }
  return parameters;
}

Eigen::VectorXd flatten(const StructuredParameters& parameters) {
  Eigen::VectorXd values(structured_size());
  Eigen::Index next = 0;
  for_each_field(parameters, [&](const char*, auto&& field) {
    values.segment(next, field.size()) = field;
    next += field.size();
  });
  return values;
}

StructuredParameters unflatten(const Eigen::VectorXd& values) {
  if (values.size() != structured_size()) {
    throw BadInput(fmt::format("{} parameters of a structured policy, not {}", values.size(),
                               structured_size()));
  }
  StructuredParameters parameters;
  Eigen::Index next = 0;
  for_each_field(parameters, [&](const char*, auto&& field) {
    field = values.segment(next, field.size());
    next += field.size();
  });
  return parameters;
}

Eigen::Index structured_size() {
  Eigen::Index size = 0;
  StructuredParameters parameters;
  for_each_field(parameters, [&](const char*, auto&& field) { size += field.size(); });
  return size;
}

}  // namespace palpate::relocate
