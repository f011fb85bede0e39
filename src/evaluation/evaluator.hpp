// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {

/// Watches a simulated pick with the simulator's truth and evaluates it afterwards.
class Evaluator {
 public:
  explicit Evaluator(const simulation::World& world) : world_(world) {}

  /// Notes the truth of the tick that ended with this reading.
  void observe(const hand::HandReading& reading);

  TrialMetrics metrics(const skills::PickResult& result, const estimation::EventLog& log,
                       const skills::LiftOptions& lift,
                       const std::vector<Eigen::Matrix3d>& symmetries) const;

  /// To be asked when placing is over.
  PlaceMetrics place_metrics(const skills::PlaceResult& result, const skills::PlaceTarget& target,
                             const estimation::EventLog& log,
                             const geometry::KnownObject& object) const;

 private:
  /// Whether an estimate in the closed hand, of that reading, was right.
  bool right_in_hand(const std::optional<estimation::HeldPoseEstimate>& estimate,
                     std::size_t closed, const estimation::EventLog& log,
                     const std::vector<Eigen::Matrix3d>& symmetries) const;
  void evaluate_tracked(const skills::PickResult& result,
                        const std::vector<Eigen::Matrix3d>& symmetries,
                        TrialMetrics& metrics) const;
  double motion_while_explored(const estimation::EventLog& log) const;
  Eigen::Isometry3d object_at(const estimation::EventLog& log, std::size_t reading) const;
  bool left_the_hand(const estimation::EventLog& log, std::size_t first, std::size_t last) const;

  struct Moment {
    Eigen::Isometry3d T_mount_object;
    double lowest_point;
  };
  const simulation::World& world_;
  std::vector<Moment> moments_;  // one a reading
};

}  // namespace palpate::evaluation
