// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "palpate/localization/next_touch.hpp"
#include "palpate/pipeline/locate.hpp"
#include "palpate/pipeline/phase.hpp"

namespace palpate::pipeline {

struct ProbeOptions {
  int most = 3;                    ///< touches at most; 0: none
  double certain = 0.97;           ///< weight of a pose that needs none
  double least_information = 0.1;  ///< nats that a touch must be expected to tell
  double opening = 0.5;            ///< of J3 before a finger moves to another spot, rad
  double spread = 0.25;            ///< of J4 to either side, at most, rad
  double bend = 0.6;               ///< of J0, to reach lower or higher, at most, rad
  double elsewhere = 0.006;        ///< m between spots of a finger that are not the same
  double likely = 0.6;             ///< chance of a touch at another spot that a move must have
  double closing_rate = 0.8;       ///< of J3, rad/s
  double torque = 0.06;            ///< N m at J3 while closing
  double touch_force = 0.1;        ///< N at the fingertip
  double balance = 0.15;           ///< imbalance that the other fingers' forces may have
  double friction = 0.5;           ///< that their balance counts on

  template <class Visitor>
  void visit(Visitor&& v) {
    v("most", most, 0, 64, "touches at most; 0: none");
    v("certain", certain, 0.0, 1.0, "weight of a pose that needs none");
    v("least_information", least_information, 0.0, 10.0, "nats that a touch is expected to tell");
    v("opening", opening, 0.1, 1.5, "rad, of J3 before a finger moves to another spot");
    v("spread", spread, 0.0, 0.35, "rad, of J4 to either side, at most");
    v("bend", bend, 0.0, 1.5, "rad, of J0, at most");
    v("elsewhere", elsewhere, 0.0, 0.05, "m between spots that are not the same");
    v("likely", likely, 0.0, 1.0, "chance that a move must have of a touch at another spot");
    v("closing_rate", closing_rate, 0.05, 5.0, "rad/s, of J3");
    v("torque", torque, 0.01, 1.0, "N m at J3 while closing");
    v("touch_force", touch_force, 0.02, 5.0, "N at the fingertip");
    v("balance", balance, 0.0, 2.0, "imbalance that the other fingers' forces may have");
    v("friction", friction, 0.0, 2.0, "that their balance counts on");
  }
};

/// Touches the object in the hand at other spots, one finger at a time, while the best pose is in
/// doubt. The moves are those that should make a finger meet the object where it has not been, by
/// the poses in question; of them the one of which most is to be learnt is made, by a finger that
/// the others can do without: they take over what it held. Then all is as before.
class ProbePhase : public Phase {
 public:
  /// @param press  of all fingers together, N, as the grasp's
  ProbePhase(const localization::ObjectModel& object, const ProbeOptions& options,
             const LocateOptions& locate, double press, std::uint64_t seed)
      : object_(object), options_(options), locate_(locate), press_(press), seed_(seed) {}
  std::string_view name() const override { return "probe"; }
  double time_limit() const override { return 60.0; }
  PhaseEnd run(Robot& robot, PickState& state) override;

 private:
  /// A finger that the others can do without, and what they do meanwhile.
  struct FreeFinger {
    int finger = 0;
    hand::ActuatorVector held;  ///< the whole hand, pressing without this finger
  };
  /// A finger moved to another spot while the others hold: its actuators before it closes again.
  struct FingerMove {
    int finger = 0;
    hand::ActuatorVector opened;  ///< of the whole hand
  };
  /// How a move should end, by the poses in question.
  struct Foresight {
    double chance = 0;  ///< that the tip meets the object where it has not touched it
    localization::Probe probe{{0, 0, 0}, {0, 0, 0}};  ///< the tip's way, as if it were straight
  };

  static bool same(const FingerMove& a, const FingerMove& b);
  std::vector<FreeFinger> free_fingers(const Robot& robot, const PickState& state) const;
  std::vector<FingerMove> moves(const Robot& robot, const FreeFinger& free) const;
  Foresight foresee(const Robot& robot, const PickState& state, const FingerMove& move,
                    const std::vector<Eigen::Vector3d>& known) const;
  std::optional<FingerMove> choose(const Robot& robot, const PickState& state,
                                   const std::vector<FingerMove>& made) const;
  bool touch(Robot& robot, const FingerMove& move) const;

  const localization::ObjectModel& object_;
  ProbeOptions options_;
  LocateOptions locate_;
  double press_;
  std::uint64_t seed_;
};

}  // namespace palpate::pipeline
