// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "palpate/hand/assembled_hand.hpp"
#include "python_hand.hpp"

namespace palpate::python {

/// An arm whose move(), read() and check_path() are Python's, found by their names. What they raise
/// is kept and thrown as a std::runtime_error.
class PythonArm : public hand::Arm {
 public:
  PythonArm(std::string name, const hand::MountLimits& limits)
      : name_(std::move(name)), limits_(limits) {}

  [[nodiscard]] std::string name() const override { return name_; }
  void move(const hand::MountPosition& target) override;
  std::optional<hand::ArmReading> read() override;
  [[nodiscard]] hand::PathFeasibility check_path(
      std::span<const hand::MountPosition> way) const override;
  [[nodiscard]] hand::MountLimits mount_limits() const override { return limits_; }

  mutable Raised raised;

 private:
  std::string name_;
  hand::MountLimits limits_;
};

/// A sensor whose read() is Python's.
class PythonSensor : public hand::Sensor {
 public:
  explicit PythonSensor(std::string finger) : finger_(std::move(finger)) {}

  [[nodiscard]] const std::string& finger() const { return finger_; }
  std::optional<std::vector<hand::TipContact>> read() override;

  Raised raised;

 private:
  std::string finger_;
};

void bind_robot_parts(nanobind::module_& module);
/// Arms as data, their kinematics, and what follows the mount in joint space.
void bind_arm_kinematics(nanobind::module_& module);

}  // namespace palpate::python
