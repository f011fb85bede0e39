// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/recording/sink.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/pick.hpp"

namespace palpate::evaluation {

/// Passes on to a recording, if there is one, what happens in a simulated pick.
class Recorder {
 public:
  Recorder(recording::Sink* sink, const simulation::World& world) : sink_(sink), world_(world) {}

  /// @throws std::runtime_error if the simulation has become unstable
  void frame(const hand::HandReading& reading, const hand::HandCommand& command);
  void event(estimation::TouchEvent event);
  /// Notes the credible poses of the resting object, for the page.
  void posterior(const localization::Posterior& posterior);
  void estimate(double time, const estimation::HeldPoseEstimate& estimate);

  /// Notes where the object was to come, the way planned there, and the fixture, for the page.
  void placement(const skills::PlaceResult& placed, const planning::Fixture& fixture);

  /// Observer that records the phases and calls another one.
  skills::PhaseObserver phases_and(const skills::PhaseObserver& other);

 private:
  recording::Sink* sink_;
  const simulation::World& world_;
  std::string phase_;
  double time_ = 0;
};

}  // namespace palpate::evaluation
