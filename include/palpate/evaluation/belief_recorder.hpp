// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "palpate/estimation/held_pose_follower.hpp"
#include "palpate/recording/sink.hpp"
#include "palpate/skills/pick.hpp"

namespace palpate::evaluation {

/// Works out what is to be believed of the object's pose while a pick goes on, from what the hand
/// measures and nothing of the truth, in a thread of its own: before the first touch, after each
/// touch and each guarded move that touched nothing, when the fingers had closed and when the
/// object hung, and from then on ten times a second by the estimator that runs along.
///
/// The pick is not changed by it, and the result does not depend on how fast either is.
class BeliefRecorder : public recording::Sink {
 public:
  /// Called with each belief, in the order of time, in the recorder's thread.
  using Observer = std::function<void(const recording::BeliefRecord&)>;

  struct Options {
    skills::PickOptions pick;          ///< as the pick's
    estimation::HeldPoseOptions held;  ///< once the object is held
    bool online = true;                ///< ten times a second then
  };

  /// @param object  kept by reference
  /// @param hand    as it is believed to be before its calibration
  BeliefRecorder(const geometry::ObjectModel& object, const hand::Description& hand,
                 const Options& options, std::uint64_t seed, Observer observer = {});
  ~BeliefRecorder() override;
  BeliefRecorder(const BeliefRecorder&) = delete;
  BeliefRecorder& operator=(const BeliefRecorder&) = delete;

  void frame(const recording::Frame& frame) override;
  void event(const recording::Event& event) override;
  void estimate(const recording::EstimateRecord&) override {}
  void belief(const recording::BeliefRecord&) override {}

  /// Waits until all that was given so far is processed; nothing may be given after that.
  std::vector<recording::BeliefRecord> finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::evaluation
