// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/pipeline/pick.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/simulation/world.hpp"

namespace palpate::pipeline {

/// Passes on to a recording, if there is one, what happens in a simulated pick.
class Recorder {
 public:
  Recorder(recording::Writer* writer, const simulation::World& world)
      : writer_(writer), world_(world) {}

  void frame(const hand::HandReading& reading, const hand::HandCommand& command);
  void mark(Mark mark);
  void estimate(double time, const PoseEstimate& estimate);

  /// Notes where the object was to come, the way planned there, and the fixture, for the page.
  void placement(const PlaceResult& placed, const simulation::Fixture& fixture);

  /// Observer that records the phases and tells another one.
  PhaseObserver phases_and(const PhaseObserver& other);

 private:
  recording::Writer* writer_;
  const simulation::World& world_;
  std::string phase_;
  double time_ = 0;
};

/// The touch log of a recording: what the estimator needs of it, and nothing of the truth.
TouchLog touch_log(const recording::Recording& recording);

}  // namespace palpate::pipeline
