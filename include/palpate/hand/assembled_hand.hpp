// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// A part of a robot answered too late, or not at all. The executor takes it for Fault::silent.
class LateAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What an arm measures.
struct ArmReading {
  MountPosition mount;  ///< of the hand's mount in the world
  /// Force of the arm on the hand, as HandReading::mount_force: N, world axes.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
};

/// What carries a hand's mount, with its own connection and controller.
class Arm {
 public:
  virtual ~Arm() = default;
  [[nodiscard]] virtual std::string name() const = 0;

  /// Brings the mount there by the end of this tick; does not wait for it.
  virtual void move(const MountPosition& target) = 0;
  /// At the end of the tick. @return nothing where there is nothing newer than the last reading
  virtual std::optional<ArmReading> read() = 0;

  /// As of Hand.
  [[nodiscard]] virtual PathFeasibility check_path(std::span<const MountPosition> way) const {
    static_cast<void>(way);
    return {};
  }
  [[nodiscard]] virtual MountLimits mount_limits() const { return {}; }
  [[nodiscard]] virtual ArmPosture arm_posture() const { return {}; }
};

/// A tactile sensor of one fingertip.
class Sensor {
 public:
  virtual ~Sensor() = default;
  /// At the end of the tick, in the frame of the finger's distal link.
  /// @return nothing where there is nothing newer than the last reading
  virtual std::optional<std::vector<TipContact>> read() = 0;
};

/// A sensor and the finger that it is on.
struct MountedSensor {
  Sensor* sensor = nullptr;
  int finger = 0;    ///< index into Description::fingers
  std::string name;  ///< in messages
};

/// How long parts may take to answer.
struct AnswerLimits {
  double wait = 0;    ///< s of wall time of one call; 0: no limit
  double gap = 0.25;  ///< s of ticks without anything newer
};

/// A hand whose parts are connected by themselves: the fingers, an arm that carries them, sensors
/// at their tips.
///
/// In a tick the arm is given its target, then the fingers make their step, which lasts the tick,
/// then arm and sensors are read. What the fingers say of the mount gives way to the arm, what they
/// say of a fingertip's contacts to the sensors on it. The time of the last reading is repeated
/// until every part has given something newer than that one holds, be it in different ticks.
class AssembledHand : public Hand {
 public:
  /// @param fingers, arm, sensors  must outlive this; no arm: the mount is the fingers' own
  /// @throws BadInput for a sensor that is missing, or on no finger
  AssembledHand(Hand& fingers, Arm* arm, std::vector<MountedSensor> sensors,
                const AnswerLimits& limits = {});

  /// All parts are asked even if one fails. Only the first failure is thrown: what remains of the
  /// hand can be eased after it. A new executor needs a new AssembledHand.
  /// @throws LateAnswer, or std::runtime_error for whatever a part throws; both name the part
  HandReading step(const HandCommand& command) override;

  /// What all parts sense, if the fingers can tell. @throws as step()
  std::optional<HandReading> sense() override;

  /// What the arm throws is thrown by the next step(), which then moves nothing.
  [[nodiscard]] PathFeasibility check_path(std::span<const MountPosition> way) const override;
  [[nodiscard]] MountLimits mount_limits() const override;
  [[nodiscard]] ArmPosture arm_posture() const override;

 private:
  struct Part {
    std::string name;
    bool known = false;  // has answered once
    bool newer = false;  // has answered since the time last advanced
    int missed = 0;      // ticks in a row without anything newer
  };

  template <class Call>
  void ask(const Part& part, const Call& call);
  void note_newer(Part& part, bool newer);
  void note_failure(const Part& part, std::string_view what) const;
  void step_parts(const HandCommand& command);
  void read_parts();
  void throw_failure();
  void read_arm();
  void read_sensor(std::size_t index);
  void assemble(HandReading&& reading);
  [[nodiscard]] bool complete() const;
  bool take_newer();

  Hand& fingers_;
  Arm* arm_;
  std::vector<MountedSensor> sensors_;
  AnswerLimits limits_;
  Part fingers_part_, arm_part_;
  std::vector<Part> sensor_parts_;
  ArmReading mount_;                                   // the arm's last
  std::vector<std::vector<TipContact>> tip_contacts_;  // each sensor's last
  HandReading reading_;                                // the last
  bool stopped_ = false;                               // a failure has been thrown
  mutable std::exception_ptr failure_;                 // the first that was not
};

}  // namespace palpate::hand
