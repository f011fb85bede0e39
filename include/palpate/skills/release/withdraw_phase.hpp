// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/phase.hpp"

namespace palpate::skills {

struct WithdrawOptions {
  double speed = 0.05;     ///< m/s, out of the object's reach
  double distance = 0.12;  ///< m
  double caught = 0.3;     ///< N on the mount that mean the object comes along
  double height = 0.34;    ///< m, where the mount then waits
  double far_speed = 0.3;  ///< m/s, up there
  double empty = 0.25;     ///< share of the object's weight that must not hang in the hand

  template <class Visitor>
  void visit(Visitor&& v) {
    v("speed", speed, 0.001, 0.5, "m/s, speed of the withdrawal from the object");
    v.expert("distance", distance, 0.01, 0.5, "m, distance of the withdrawal from the object");
    v.expert("caught", caught, 0.05, 10.0,
             "N, load on the mount above which the object counts as pulled along");
    v("height", height, 0.1, 1.0, "m, height at which the mount waits afterwards");
    v.expert("far_speed", far_speed, 0.01, 1.0, "m/s, speed of the rise after the withdrawal");
    v.expert("empty", empty, 0.0, 1.0,
             "share of the object's weight above which the object counts as still held");
  }
};

/// Takes the open hand away upwards. Where something pulls, the hand goes back, opens wider and
/// tries again. At the end the mount must carry nothing.
class WithdrawPhase : public Phase {
 public:
  /// @param weight  of the object, N
  /// @param event  at the end: `opened` where the object is grasped again and what is known of its
  ///   pose still holds
  WithdrawPhase(const WithdrawOptions& options, double weight,
                estimation::TouchEvent event = estimation::TouchEvent::released)
      : options_(options), weight_(weight), event_(event) {}
  std::string_view name() const override { return "withdraw"; }
  double time_limit() const override { return 30.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  WithdrawOptions options_;
  double weight_;
  estimation::TouchEvent event_;
};

}  // namespace palpate::skills
