// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/skills/phase.hpp"

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

/// Where the mount has to go, as measured, and the pose of the object that this is for.
struct PlaceGoal {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< one of equal targets
  Eigen::Isometry3d T_mount_object = Eigen::Isometry3d::Identity();  ///< that it counts on
  hand::MountPosition mount;                                         ///< object at the target
  hand::MountPosition above;                                         ///< object over it
  double sunk = 0;  ///< m by which the object hangs lower than it counts on, and is met earlier
};

/// Lets the object down until the table bears it (guarded descent), presses it flat, and lets go.
/// A contact much too early is a refusal: where a fixture may be the reason, the next try is a
/// little aside.
class SetDownPhase : public Phase {
 public:
  /// @param wall  m, height of the fixture's walls; 0: none
  SetDownPhase(const LowerOptions& options, const PlaceGoal& goal, double wall,
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

}  // namespace palpate::skills
