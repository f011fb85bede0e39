// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/posterior.hpp"
#include "palpate/skills/executor.hpp"
#include "skills/probe/probe_choice.hpp"

namespace palpate::skills {

/// s that the hand stands still, for the mean of its load to hold nothing of its motion.
inline constexpr double kSettleSeconds = 0.4;

/// A turn of the hand after which the object it holds is let down onto the table.
struct TableTouch {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< about the object's centroid, world, rad
  double lowest = 0;  ///< expected height of the object's lowest point over its centroid then, m
  double sigma = 0;   ///< of that, m
  ExpectedGain expected_gain;
};

/// Chooses such turns: each for its expected information beside those before.
class TableTouchChoice {
 public:
  /// @param held  in the world, with modes; the hand is where it is by the last reading
  TableTouchChoice(const Executor& robot, const geometry::ObjectModel& object,
                   const localization::Posterior& held, RandomStream random);

  /// The turn of which most is to be learnt, of those not made yet in which the object is lower
  /// than any part of the hand.
  [[nodiscard]] std::optional<TableTouch> next() const;

  /// The hand's mount once it has turned, the object's centroid where it is.
  [[nodiscard]] Eigen::Isometry3d turned_mount(const TableTouch& touch) const;
  /// Height of the object's centroid over the table, m.
  [[nodiscard]] double height() const { return centroid_.z(); }

  /// Of its centroid, at which the object turns clear of the table; not above height(), m.
  [[nodiscard]] double travel_height() const;

  /// Share of the posterior that is within 2.5 deg and 3.5 mm of the best pose, by the touches
  /// made.
  [[nodiscard]] double tight_share() const;

  /// The turn has been made. @param lowest  as it was found, where the table was met
  void made(const TableTouch& touch, std::optional<double> lowest);

 private:
  [[nodiscard]] std::vector<double> lowest_points(const Eigen::Vector3d& turn) const;
  [[nodiscard]] double lowest_of_hand(const Eigen::Vector3d& turn) const;
  [[nodiscard]] std::optional<TableTouch> judged(const Eigen::Vector3d& turn) const;

  const geometry::ObjectModel& object_;
  Eigen::Isometry3d mount_;
  std::vector<std::pair<Eigen::Vector3d, double>> hand_;  // balls of its surface, world
  double in_modes_;                                       // share of the posterior
  Eigen::Isometry3d best_;                                // of the posterior, world
  Eigen::Vector3d centroid_;                              // of the best pose, world
  std::vector<Eigen::Isometry3d> poses_;                  // drawn from the posterior, world
  std::vector<double> weights_;                           // of them, by the touches made
  std::vector<Eigen::Vector3d> done_;
};

/// Turns the hand, lets the object down until the table bears some of its weight, records
/// `table_touched`, and goes up again.
/// @param min_load  N that must hang on the mount, once it stands, for anything to be let down
/// @return the lowest point over the object's centroid; none: the table was not met
std::optional<double> touch_table(Executor& robot, const TableTouchChoice& choice,
                                  const TableTouch& touch, double min_load);

}  // namespace palpate::skills
