// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/execution.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/hand/kinematics.hpp"

namespace palpate::planning {
namespace {

/// Adds the errors of one kind of coordinate.
class Errors {
 public:
  template <class Vector>
  void add(const Vector& error, double count) {
    squares_ += error.squaredNorm();
    count_ += count;
    largest_ = std::max(largest_, error.template lpNorm<Eigen::Infinity>());
  }
  [[nodiscard]] double rms() const { return count_ == 0 ? 0 : std::sqrt(squares_ / count_); }
  [[nodiscard]] double largest() const { return largest_; }

 private:
  double squares_ = 0, count_ = 0, largest_ = 0;
};

/// 1 for the coordinates that the samples move, 0 for those that rest.
Coordinates moving(const std::vector<hand::HandCommand>& samples) {
  if (samples.empty()) return {};
  const Eigen::Index size = kMountCoordinates + samples.front().positions.size();
  Coordinates mask = Coordinates::Zero(size);
  for (const hand::HandCommand& command : samples) {
    const Coordinates way = coordinates_of(command) - coordinates_of(samples.front());
    mask = (way.array() != 0).select(Coordinates::Ones(size), mask);
  }
  return mask;
}

/// Where the mount is at a tick, between the samples; at rest after the last.
hand::MountPosition mount_at(const std::vector<hand::HandCommand>& samples, double tick) {
  const auto before = std::min(static_cast<std::size_t>(tick), samples.size() - 1);
  const auto after = std::min(before + 1, samples.size() - 1);
  const double share = std::min(1.0, tick - static_cast<double>(before));
  const hand::MountPosition& a = samples[before].mount;
  const hand::MountPosition& b = samples[after].mount;
  return {.xyz = a.xyz + share * (b.xyz - a.xyz), .ypr = a.ypr + share * (b.ypr - a.ypr)};
}

}  // namespace

TrackingError execute(hand::Hand& hand, const hand::Description& model,
                      const std::vector<hand::HandCommand>& samples,
                      const ExecutionOptions& options) {
  TrackingError result;
  const Coordinates mask = moving(samples);
  Errors slides, turns, joints;
  for (std::size_t tick = 0; tick < samples.size(); ++tick) {
    const hand::HandCommand& wanted = samples[tick];
    const double ahead = static_cast<double>(tick) + options.mount_lead / hand::kTick;
    const hand::HandReading reading =
        hand.step({.positions = wanted.positions, .mount = mount_at(samples, ahead)});
    result.measured.push_back(coordinates_of(
        {.positions = hand::actuator_positions(model, reading.joints), .mount = reading.mount}));
    const Coordinates error = mask.cwiseProduct(result.measured.back() - coordinates_of(wanted));
    slides.add(error.head<3>(), mask.head<3>().sum());
    turns.add(error.segment<3>(3), mask.segment<3>(3).sum());
    const Eigen::Index actuators = error.size() - kMountCoordinates;
    joints.add(error.tail(actuators), mask.tail(actuators).sum());
  }
  result.joint_rms = joints.rms(), result.joint_max = joints.largest();
  result.mount_rms = slides.rms(), result.mount_max = slides.largest();
  result.turn_rms = turns.rms(), result.turn_max = turns.largest();
  return result;
}

}  // namespace palpate::planning
