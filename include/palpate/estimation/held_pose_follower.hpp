// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/estimation/estimate.hpp"
#include "palpate/estimation/online_tracker.hpp"

namespace palpate::estimation {

struct HeldPoseOptions {
  double period = 0.1;                ///< s from one estimate to the next, at least
  int fingers = 2;                    ///< that must touch for an estimate
  double lost_after = 0.5;            ///< s with fewer, after which nothing is known any more
  double rotation_sigma = 0.01;       ///< rad, by which a held object turns in a period, per axis
  double translation_sigma = 0.0005;  ///< m, by which it moves so
  double slip_share = 0.05;           ///< probability that it moves farther in a period
  double slip_rotation = 0.2;         ///< rad, sigma of a turn then, per axis
  double slip_translation = 0.008;    ///< m, of a way
  /// Search where nothing is known, as EstimationOptions::search.
  localization::LocalizerOptions first{.first_point_sigma = 0.0015};
  EstimationOptions estimation = estimation_in_motion();  ///< and afterwards

  template <class Visitor>
  void visit(Visitor&& v) {
    v("period", period, 0.01, 10.0, "s, least time between two estimates");
    v("fingers", fingers, 1, hand::kMaxFingers,
      "number of fingers that must touch for an estimate");
    v("lost_after", lost_after, 0.05, 100.0,
      "s with fewer fingers, after which the object counts as lost");
    v("rotation_sigma", rotation_sigma, 1e-4, 3.0, "rad, rotation of a held object per period");
    v("translation_sigma", translation_sigma, 1e-5, 0.2,
      "m, translation of a held object per period");
    v("slip_share", slip_share, 0.0, 0.9,
      "probability that a held object moves farther in a period: a slip");
    v("slip_rotation", slip_rotation, 1e-4, 3.0, "rad, rotation in a slip");
    v("slip_translation", slip_translation, 1e-5, 0.2, "m, translation in a slip");
    v.section("first", first);
    v.section("estimation", estimation);
  }
};

/// The pose of what a hand holds, from its readings alone: nothing need be known of how it came
/// into the hand. Between estimates the object goes with the palm while fingers touch it. Contacts
/// that stay where they were add no information, for their errors stay, too: a search is made where
/// a finger touches elsewhere.
///
/// update() takes microseconds. An estimate takes longer than a tick and may be made by another
/// thread: task() is what it needs, accept() takes its result, while readings go on.
class HeldPoseFollower {
 public:
  /// What an estimate is made from.
  struct Task {
    EventLog log;                                  ///< the last readings
    Eigen::Isometry3d motion;                      ///< of the object until the last of them
    std::optional<localization::PosePrior> prior;  ///< in the hand's mount
    std::optional<localization::Posterior> known;  ///< the contacts add nothing; in the world
    std::uint64_t number = 0, epoch = 0;
  };

  /// Keeps a reference to the object.
  HeldPoseFollower(const geometry::ObjectModel& object, hand::Description hand,
                   HeldPoseOptions options, std::uint64_t seed);

  /// A reading of an earlier time than the last one is of a clock that was set back: all is
  /// forgotten before it is taken.
  void update(const hand::HandReading& reading);

  /// The pose is known at the last reading, in the world.
  void begin(const localization::Posterior& posterior);

  /// Whether enough fingers touch, and the last task is a period old.
  bool due() const;
  Task task();
  /// In the world, at the task's last reading.
  HeldPoseEstimate estimate(const Task& task) const;
  /// Ignored where the object has been lost, or all forgotten, since the task.
  void accept(const Task& task, HeldPoseEstimate estimate);

  /// In the world, at the last reading; without modes where nothing is known.
  localization::Posterior posterior() const;
  void forget();

 private:
  void restart(double time);
  Eigen::Isometry3d carried() const;
  localization::PosePrior prior() const;
  std::vector<tactile::Contact> contacts() const;
  bool has_new_contacts() const;
  void use(std::vector<tactile::Contact> contacts, const Eigen::Isometry3d& T_mount_world);

  const geometry::ObjectModel& object_;
  hand::Description hand_;
  HeldPoseOptions options_;
  RandomStream random_;
  EventLog log_;  ///< of the last readings
  Eigen::Isometry3d T_world_palm_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity();  ///< of the object, in the world
  Eigen::Isometry3d motion_of_known_ = Eigen::Isometry3d::Identity();  ///< until it was known
  localization::Posterior known_;                                      ///< in the world
  std::vector<tactile::Contact> used_;  ///< a finger's last that were reckoned with; in the mount
  double known_at_ = 0, touched_at_ = 0, asked_at_ = 0;  ///< s
  std::uint64_t tasks_ = 0, epoch_ = 0;
};

}  // namespace palpate::estimation
