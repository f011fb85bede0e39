// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/execution.hpp"

#include <cmath>

namespace palpate::planning {
namespace {

/// Adds the errors of one kind of coordinate.
class Errors {
 public:
  template <class Vector>
  void add(const Vector& error) {
    squares_ += error.squaredNorm();
    count_ += static_cast<int>(error.size());
    largest_ = std::max(largest_, error.template lpNorm<Eigen::Infinity>());
  }
  [[nodiscard]] double rms() const { return count_ == 0 ? 0 : std::sqrt(squares_ / count_); }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  double squares_ = 0, largest_ = 0;
  int count_ = 0;
};

}  // namespace

TrackingError execute(hand::Hand& hand, const std::vector<hand::HandCommand>& samples) {
  TrackingError result;
  Errors slides, turns, joints;
  for (const hand::HandCommand& command : samples) {
    const hand::HandReading reading = hand.step(command);
    result.measured.push_back(coordinates_of(
        {.positions = hand::actuator_positions(reading.joints), .base = reading.base}));
    const Coordinates error = result.measured.back() - coordinates_of(command);
    slides.add(error.head<3>());
    turns.add(error.segment<3>(3));
    joints.add(error.tail<hand::kActuators>());
  }
  result.joint_rms = joints.rms(), result.joint_max = joints.largest();
  result.base_rms = slides.rms(), result.base_max = slides.largest();
  result.turn_rms = turns.rms(), result.turn_max = turns.largest();
  return result;
}

}  // namespace palpate::planning
