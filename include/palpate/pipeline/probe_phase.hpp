// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/locate.hpp"
#include "palpate/pipeline/phase.hpp"

namespace palpate::pipeline {

struct ProbeOptions {
  int most = 3;                    ///< touches at most; 0: none
  double certain = 0.97;           ///< weight of a pose that needs none
  double least_information = 0.1;  ///< nats that a touch must be expected to tell
  double opening = 0.5;            ///< of J3 before a finger moves to another spot, rad
  double spread = 0.25;            ///< of J4 to either side, rad
  double bend = 0.5;               ///< of J0, to reach lower or higher, rad
  double closing_rate = 0.8;       ///< of J3, rad/s
  double torque = 0.06;            ///< N m at J3 while closing
  double touch_force = 0.1;        ///< N at the fingertip
  double balance = 0.3;            ///< imbalance that the other fingers' forces may have
  double friction = 0.5;           ///< that their balance counts on
  double press = 5;                ///< N, of the other fingers together

  template <class Visitor>
  void visit(Visitor&& v) {
    v("most", most, 0, 64, "touches at most; 0: none");
    v("certain", certain, 0.0, 1.0, "weight of a pose that needs none");
    v("least_information", least_information, 0.0, 10.0, "nats that a touch is expected to tell");
    v("opening", opening, 0.1, 1.5, "rad, of J3 before a finger moves to another spot");
    v("spread", spread, 0.0, 0.35, "rad, of J4 to either side");
    v("bend", bend, 0.0, 1.5, "rad, of J0");
    v("closing_rate", closing_rate, 0.05, 5.0, "rad/s, of J3");
    v("torque", torque, 0.01, 1.0, "N m at J3 while closing");
    v("touch_force", touch_force, 0.02, 5.0, "N at the fingertip");
    v("balance", balance, 0.0, 2.0, "imbalance that the other fingers' forces may have");
    v("friction", friction, 0.0, 2.0, "that their balance counts on");
    v("press", press, 0.1, 100.0, "N, of the other fingers together");
  }
};

/// A finger moved to another spot while the others hold: its actuators before it closes again.
struct FingerMove {
  int finger = 0;
  hand::ActuatorVector opened;  ///< of the whole hand
};

/// Touches the object in the hand at other spots, one finger at a time, while the best pose is in
/// doubt. The spots are chosen by the information expected of them, among those of fingers that the
/// others can do without, as the balance of their forces tells. Each finger returns to where it
/// held the object.
class ProbePhase : public Phase {
 public:
  /// @param weight  of the object, N
  ProbePhase(const localization::ObjectModel& object, const ProbeOptions& options,
             const LocateOptions& locate, double weight, std::uint64_t seed)
      : object_(object), options_(options), locate_(locate), weight_(weight), seed_(seed) {}
  std::string_view name() const override { return "probe"; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  std::vector<int> free_fingers(const Robot& robot) const;
  std::vector<FingerMove> moves(const Robot& robot, int finger) const;
  std::optional<FingerMove> choose(const Robot& robot, const PickState& state,
                                   const std::vector<FingerMove>& made) const;
  bool touch(Robot& robot, const FingerMove& move) const;

  const localization::ObjectModel& object_;
  ProbeOptions options_;
  LocateOptions locate_;
  double weight_;
  std::uint64_t seed_;
};

}  // namespace palpate::pipeline
