// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/assembled_hand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::hand {
namespace {

using PartClock = std::chrono::steady_clock;

}  // namespace

AssembledHand::AssembledHand(Hand& fingers, Arm* arm, std::vector<MountedSensor> sensors,
                             const AnswerLimits& limits)
    : fingers_(fingers),
      arm_(arm),
      sensors_(std::move(sensors)),
      limits_(limits),
      fingers_part_{"the fingers"},
      arm_part_{arm ? fmt::format("the arm '{}'", arm->name()) : std::string()},
      tip_contacts_(sensors_.size()) {
  for (const MountedSensor& mounted : sensors_) {
    if (mounted.sensor == nullptr || mounted.finger < 0) {
      throw BadInput(fmt::format("the sensor '{}' {}", mounted.name,
                                 mounted.sensor ? "is on no finger" : "is missing"));
    }
    sensor_parts_.push_back({fmt::format("the sensor '{}'", mounted.name)});
  }
}

HandReading AssembledHand::step(const HandCommand& command) {
  do {  // again as long as there is a part that has never answered
    if (!failure_) step_parts(command);
  } while (!failure_ && !stopped_ && !complete());
  throw_failure();
  return reading_;
}

std::optional<HandReading> AssembledHand::sense() {
  std::optional<HandReading> fingers;
  ask(fingers_part_, [&] { fingers = fingers_.sense(); });
  if (fingers) read_parts();
  while (fingers && !failure_ && !complete()) {
    std::this_thread::sleep_for(std::chrono::duration<double>(kTick));
    read_parts();
  }
  throw_failure();
  if (!fingers) return std::nullopt;
  assemble(*std::move(fingers));
  return reading_;
}

void AssembledHand::throw_failure() {
  if (const auto failure = std::exchange(failure_, nullptr); failure && !stopped_) {
    stopped_ = true;
    std::rethrow_exception(failure);
  }
}

void AssembledHand::step_parts(const HandCommand& command) {
  if (arm_) ask(arm_part_, [&] { arm_->move(command.mount); });
  HandReading reading = reading_;
  ask(fingers_part_, [&] { reading = fingers_.step(command); });
  read_parts();
  assemble(std::move(reading));
}

void AssembledHand::read_parts() {
  if (arm_) ask(arm_part_, [&] { read_arm(); });
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    ask(sensor_parts_[i], [&] { read_sensor(i); });
  }
}

/// Calls a part; what it throws, and that it took too long, is the failure that step() throws.
template <class Call>
void AssembledHand::ask(const Part& part, const Call& call) {
  const auto begin = PartClock::now();
  try {
    call();
    const double taken = std::chrono::duration<double>(PartClock::now() - begin).count();
    if (limits_.wait > 0 && taken > limits_.wait) {
      throw LateAnswer(fmt::format("{} took {:.2f} s to answer, at most {} s are allowed",
                                   part.name, taken, limits_.wait));
    }
  } catch (const LateAnswer&) {
    if (!failure_) failure_ = std::current_exception();
  } catch (const std::exception& error) {
    note_failure(part, error.what());
  } catch (...) {
    note_failure(part, "an unknown exception");
  }
}

void AssembledHand::note_failure(const Part& part, std::string_view what) const {
  const auto named = std::runtime_error(fmt::format("{}: {}", part.name, what));
  if (!failure_) failure_ = std::make_exception_ptr(named);
}

void AssembledHand::read_arm() {
  const auto now = arm_->read();
  if (now) mount_ = *now;
  note_newer(arm_part_, now.has_value());
}

void AssembledHand::read_sensor(std::size_t index) {
  auto now = sensors_[index].sensor->read();
  const bool newer = now.has_value();
  if (newer) tip_contacts_[index] = *std::move(now);
  note_newer(sensor_parts_[index], newer);
}

void AssembledHand::note_newer(Part& part, bool newer) {
  part.known = part.known || newer;
  part.missed = newer ? 0 : part.missed + 1;
  part.newer = part.newer || newer;
  if (part.missed * kTick < limits_.gap) return;
  throw LateAnswer(fmt::format("{}: no new reading for {:.2f} s", part.name, part.missed * kTick));
}

/// Whether all parts have given something newer since this was last so.
bool AssembledHand::take_newer() {
  const bool arm = !arm_ || arm_part_.newer;
  if (!arm || !std::ranges::all_of(sensor_parts_, &Part::newer)) return false;
  arm_part_.newer = false;
  for (Part& part : sensor_parts_) part.newer = false;
  return true;
}

/// While the time stays the executor counts the reading as late.
void AssembledHand::assemble(HandReading&& reading) {
  if (!take_newer()) reading.time = reading_.time;
  if (arm_) {
    reading.mount = mount_.mount;
    reading.mount_force = mount_.force;
  }
  std::vector<bool> begun(reading.contacts.size());
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const auto finger = static_cast<std::size_t>(sensors_[i].finger);
    if (finger >= begun.size()) {
      note_failure(sensor_parts_[i],
                   fmt::format("on finger {} of {}", sensors_[i].finger, begun.size()));
      continue;
    }
    auto& contacts = reading.contacts[finger];
    if (!begun[finger]) contacts.clear();
    contacts.insert(contacts.end(), tip_contacts_[i].begin(), tip_contacts_[i].end());
    begun[finger] = true;
  }
  reading_ = std::move(reading);
}

bool AssembledHand::complete() const {
  return (!arm_ || arm_part_.known) &&
         std::ranges::all_of(sensor_parts_, [](const Part& part) { return part.known; });
}

PathFeasibility AssembledHand::check_path(std::span<const MountPosition> way) const {
  if (!arm_) return fingers_.check_path(way);
  try {
    return arm_->check_path(way);
  } catch (const std::exception& error) {
    note_failure(arm_part_, error.what());
  } catch (...) {
    note_failure(arm_part_, "an unknown exception");
  }
  return {};
}

ArmPosture AssembledHand::arm_posture() const {
  return arm_ ? arm_->arm_posture() : fingers_.arm_posture();
}

MountLimits AssembledHand::mount_limits() const {
  return arm_ ? arm_->mount_limits() : fingers_.mount_limits();
}

}  // namespace palpate::hand
