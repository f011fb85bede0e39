// SPDX-License-Identifier: Apache-2.0
#include "pick_recording.hpp"

#include <utility>
#include <vector>

namespace palpate::app {

void PickRecording::follow_belief(const geometry::ObjectModel& object,
                                  const hand::Description& hand, const skills::PickOptions& options,
                                  std::uint64_t seed) {
  beliefs_.emplace(object, hand, evaluation::BeliefRecorder::Options{options, {}}, seed,
                   [this](const recording::BeliefRecord& belief) {
                     if (page_) page_->belief(belief);
                   });
}

recording::Tee PickRecording::sink() {
  std::vector<recording::Sink*> sinks{&writer_};
  if (page_) sinks.push_back(page_.get());
  if (beliefs_) sinks.push_back(&*beliefs_);
  return recording::Tee(std::move(sinks));
}

void PickRecording::finish(const skills::PickResult& result) {
  if (beliefs_) {
    for (const auto& belief : beliefs_->finish()) writer_.belief(belief);
  }
  writer_.finish();
  if (page_) page_->end(result.held ? "picked" : "ended: " + result.failed_phase);
}

}  // namespace palpate::app
