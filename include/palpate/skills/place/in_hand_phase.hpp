// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "palpate/skills/phase.hpp"
#include "palpate/skills/place/place_goal.hpp"
#include "palpate/skills/reorient/in_hand_reorientation.hpp"

namespace palpate::skills {

/// Which part of the way to a target the fingers take, and how they go about it.
struct InHandReorientationOptions {
  double min = 0.0524;      ///< rad (3 deg): for less the fingers are not troubled
  double max = 0.2618;      ///< rad (15 deg) that they turn the object at most
  double min_weight = 0.5;  ///< share of the load before that must still hang afterwards
  double settle = 0.5;      ///< s of rest afterwards
  ReorientOptions reorient;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("min", min, 0.0, 1.0, "rad, least rotation of the object for which the fingers are used");
    v("max", max, 0.01, 0.6, "rad, largest rotation of the object by the fingers");
    v.expert("min_weight", min_weight, 0.0, 1.0,
             "share of the load that must still hang after the rotation");
    v.expert("settle", settle, 0.0, 10.0, "s, rest after the rotation");
    v.expert_section("reorient", reorient);
  }
};

/// What the fingers were asked and what became of it, as the robot itself knows it.
struct InHandReorientation {
  Eigen::Vector3d asked = Eigen::Vector3d::Zero();  ///< rotation vector, world's axes, rad
  double mount_rotation = 0;  ///< rad that the mount would have had to turn without it
  std::string why;            ///< the fingers were used
  ReorientResult result;      ///< with the tracked pose at the end
  bool lost = false;          ///< too little hangs in the hand afterwards
  bool known = false;         ///< the tracked pose is certain enough to go on with
};

/// The rotation (world's axes, rad) of the object in the hand that takes the most of the turn from
/// one attitude of the mount off it: along the shortest way, `most` at the longest.
Eigen::Vector3d share_of_fingers(const hand::MountPosition& from, const hand::MountPosition& to,
                                 double most);

/// The grasp after the object has turned in the hand about its centroid. What the table fixed of
/// height and tilt when the fingers closed is of no use then.
HeldObject turned_in_hand(const HeldObject& held, const hand::MountPosition& mount,
                          const Eigen::Vector3d& rotation_world);

/// A turn in the hand after which some position of the mount brings the object to the target, where
/// none does as it is held: towards the target first, then about the world's axes, short ones
/// first.
/// @param reaches  whether the object, held so, can be brought there
std::optional<Eigen::Vector3d> turn_that_reaches(
    const HeldObject& held, const hand::MountPosition& mount, const Eigen::Vector3d& towards,
    double most, const std::function<bool(const HeldObject&)>& reaches);

/// Turns the held object in the hand, the mount at rest, by reorient_in_hand. However that ends,
/// the phase goes well as long as the object hangs in the hand and the tracked pose is within the
/// drift limit: it is then the estimate. Where fingers were about to lose it, they press again.
class InHandReorientationPhase : public Phase {
 public:
  /// @param turn  with what is asked; gets the result
  InHandReorientationPhase(const InHandReorientationOptions& options,
                           const geometry::ObjectModel& object, std::uint64_t seed,
                           InHandReorientation& turn)
      : options_(options), object_(object), seed_(seed), turn_(turn) {}
  std::string_view name() const override { return "turn"; }
  double time_limit() const override;
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  InHandReorientationOptions options_;
  const geometry::ObjectModel& object_;
  std::uint64_t seed_;
  InHandReorientation& turn_;
};

}  // namespace palpate::skills
