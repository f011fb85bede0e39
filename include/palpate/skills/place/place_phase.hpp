// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/skills/phase.hpp"
#include "palpate/skills/place/place_goal.hpp"

namespace palpate::skills {

struct LowerOptions {
  double speed = 0.05;          ///< m/s, down to near the target
  double near = 0.012;          ///< m over the target from where it goes slowly
  double slow_speed = 0.008;    ///< m/s
  double contact_load = 0.4;    ///< N that the table must bear to count as contact
  double press = 1.0;           ///< N beyond the weight that lay the object flat
  double beyond = 0.015;        ///< m below the target at which it gives up
  double early = 0.008;         ///< m over the target where a contact means refusal
  double max_press = 0.006;     ///< m of way from the contact to lying flat
  double back_off = 0.004;      ///< m up between two tries
  double spiral = 0.002;        ///< m by which the tries move apart
  int tries = 7;                ///< at shifted places, after a refusal by a fixture
  double unload_seconds = 0.8;  ///< from pressing to touching
  double open_seconds = 2.0;    ///< from touching to open

  template <class Visitor>
  void visit(Visitor&& v) {
    v("speed", speed, 0.001, 0.5, "m/s, speed down to just above the target");
    v.expert("near", near, 0.0, 0.1, "m, height above the target below which the descent is slow");
    v.expert("slow_speed", slow_speed, 0.0005, 0.1, "m/s, speed of the slow descent");
    v("contact_load", contact_load, 0.05, 20.0, "N, load that counts as contact with the table");
    v("press", press, 0.0, 20.0,
      "N, force beyond the weight with which the object is pressed onto the table");
    v.expert("beyond", beyond, 0.0, 0.05, "m, depth below the target at which the descent fails");
    v.expert("early", early, 0.0, 0.1,
             "m, height above the target at which a contact counts as refusal");
    v.expert("max_press", max_press, 0.0, 0.05,
             "m, descent from the first contact until the object lies flat, at most");
    v.expert("back_off", back_off, 0.0, 0.05, "m, rise between two tries");
    v.expert("spiral", spiral, 0.0, 0.02, "m, displacement from one try to the next");
    v.expert("tries", tries, 1, 100,
             "number of tries at displaced positions after a refusal by a fixture");
    v.expert("unload_seconds", unload_seconds, 0.0, 10.0,
             "s, time over which the grasp force is released");
    v.expert("open_seconds", open_seconds, 0.1, 10.0, "s, time over which the fingers open");
  }
};

/// For setting down where the object stood: no contact is too early, for nothing else is there that
/// could refuse it.
LowerOptions never_refused(LowerOptions options);

/// Lets go of an object that stands on the table: records the event `placed`, takes the squeeze
/// back as it came, then opens slowly.
void release(Executor& robot, const LowerOptions& options);

/// Opens around an object that the hand has grasped and not lifted.
class OpenPhase : public Phase {
 public:
  explicit OpenPhase(const LowerOptions& options) : options_(options) {}
  std::string_view name() const override { return "open"; }
  double time_limit() const override { return 30.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  LowerOptions options_;
};

/// Lets the object down until the table bears it (guarded descent), presses it flat, and lets go.
/// A contact much too early is a refusal: where a fixture may be the reason, the next try is a
/// little aside.
class PlacePhase : public Phase {
 public:
  /// @param wall  m, height of the fixture's walls; 0: none
  PlacePhase(const LowerOptions& options, const PlaceGoal& goal, double wall,
             std::string name = "place")
      : options_(options), goal_(goal), wall_(wall), name_(std::move(name)) {}
  std::string_view name() const override { return name_; }
  double time_limit() const override { return 90.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

  enum class Touchdown { flat, early, nothing, lost };
  /// Pose of the object in the closed hand when the table bore it, in the world, estimated.
  const Eigen::Isometry3d& T_world_object() const { return T_world_object_; }
  bool released() const { return released_; }
  /// How the last descent ended.
  Touchdown touchdown() const { return touchdown_; }

 private:
  Touchdown lower(Executor& robot, const Eigen::Vector3d& aside);
  std::optional<Touchdown> descend(Executor& robot, const hand::MountPosition& at_goal) const;

  LowerOptions options_;
  PlaceGoal goal_;
  double wall_;
  std::string name_;
  Eigen::Isometry3d T_world_object_ = Eigen::Isometry3d::Identity();
  hand::MountPosition contact_;  // commanded at the last contact
  double height_error_ = 0;      // m, of the contact over where it was expected
  bool released_ = false;
  Touchdown touchdown_ = Touchdown::nothing;
};

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
