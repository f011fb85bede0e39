// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// Takes a recording as it happens: a file, or who watches.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void frame(const Frame& frame) = 0;
  virtual void event(const Event& event) = 0;
  virtual void estimate(const EstimateRecord& estimate) = 0;
  virtual void belief(const BeliefRecord& belief) = 0;
};

/// Passes all on to several, in their order.
class Tee : public Sink {
 public:
  /// @param sinks  that outlive it
  explicit Tee(std::vector<Sink*> sinks) : sinks_(std::move(sinks)) {}

  void frame(const Frame& frame) override {
    for (Sink* sink : sinks_) sink->frame(frame);
  }
  void event(const Event& event) override {
    for (Sink* sink : sinks_) sink->event(event);
  }
  void estimate(const EstimateRecord& estimate) override {
    for (Sink* sink : sinks_) sink->estimate(estimate);
  }
  void belief(const BeliefRecord& belief) override {
    for (Sink* sink : sinks_) sink->belief(belief);
  }

 private:
  std::vector<Sink*> sinks_;
};

}  // namespace palpate::recording
