// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/sensor_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

constexpr std::size_t kFinger = 1;

hand::TipContact contact() {
  hand::TipContact contact;
  contact.p = {0.001, 0.002, 0.003};
  contact.n = Eigen::Vector3d(1, 2, -2) / 3;
  contact.f = -contact.n;
  return contact;
}

/// Errors of a Shadow hand.
SensorErrors errors(const WorldOptions& options, std::uint64_t seed) {
  return {options, load_hand("shadow"), 40, RandomStream(seed)};
}

/// What one sensor gives in each of so many ticks for the same contact.
std::vector<hand::TipContact> sensed(SensorErrors& errors, int ticks) {
  const hand::Description hand = load_hand("shadow");
  std::vector<hand::TipContact> all;
  for (int tick = 1; tick <= ticks; ++tick) {
    hand::HandReading reading;
    reading.time = tick * hand::kTick;
    reading.joints.setZero(hand.joint_count());
    reading.torques.setZero(hand.actuator_count());
    errors.misread(reading);
    all.push_back(contact());
    errors.misread(kFinger, all.back());
  }
  return all;
}

TEST(SensorErrors, NothingIsMisreadWithoutErrors) {
  SensorErrors exact = errors(without_noise(), 1);
  const hand::TipContact read = sensed(exact, 3).back();
  EXPECT_EQ(read.p, contact().p);
  EXPECT_EQ(read.n, contact().n);
}

TEST(SensorErrors, ALargerTipShiftsItsContactsAlongTheNormal) {
  WorldOptions options = without_noise();
  options.error.tip_radius = 0.0005;
  double squares = 0;
  constexpr int kHands = 200;
  for (int seed = 0; seed < kHands; ++seed) {
    SensorErrors off = errors(options, static_cast<std::uint64_t>(seed));
    const auto read = sensed(off, 2);
    const Eigen::Vector3d shift = read[0].p - contact().p;
    EXPECT_LT(shift.cross(contact().n).norm(), 1e-12);
    EXPECT_EQ(read[1].p, read[0].p) << "always the same";
    squares += shift.squaredNorm() / kHands;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.0005, 0.1 * 0.0005);
}

TEST(SensorErrors, CorrelatedNoiseHasItsSizeAndItsTime) {
  WorldOptions options = without_noise();
  options.noise.point = 0.001;
  options.noise.normal = 0.1;
  options.noise.touch_correlation = 0.5;
  SensorErrors slow = errors(options, 4);
  EXPECT_EQ(slow.white_noise().point, 0);
  EXPECT_EQ(slow.white_noise().normal, 0);
  constexpr int kTicks = 100000, kLater = 50;
  const auto read = sensed(slow, kTicks);
  double squares = 0, products = 0, tilts = 0;
  for (int i = 0; i + kLater < kTicks; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double now = read[at].p.x() - contact().p.x();
    squares += now * now / kTicks;
    products += now * (read[at + kLater].p.x() - contact().p.x()) / kTicks;
    tilts += std::pow(std::tan(std::acos(read[at].n.dot(contact().n))), 2) / (2 * kTicks);
  }
  EXPECT_NEAR(std::sqrt(squares), 0.001, 0.1 * 0.001);
  EXPECT_NEAR(std::sqrt(tilts), 0.1, 0.1 * 0.1);
  EXPECT_NEAR(products / squares, std::exp(-kLater * hand::kTick / 0.5), 0.1);
}

TEST(SensorErrors, AJointWhoseZeroIsOffReadsWhatItWasCommanded) {
  WorldOptions options = without_noise();
  World exact(block(), options, 5);
  options.error.joint_zero = 0.02;
  World off(block(), options, 5);
  hand::HandCommand command = open_hand(0.5);
  command.positions.setConstant(0.1);  // away from the joints' limits
  exact.reset({}, command);
  off.reset({}, command);
  hand::HandReading wanted, read;
  for (int tick = 0; tick < 100; ++tick) {
    wanted = exact.hand().step(command);
    read = off.hand().step(command);
  }
  const hand::JointVector zeros = read.joints - off.truth().joints;
  EXPECT_NEAR(zeros.norm() / std::sqrt(static_cast<double>(zeros.size())), 0.02, 0.008);
  const auto drives = [&](const hand::HandReading& reading) {
    return hand::actuator_positions(off.hand_model(), reading.joints);
  };
  EXPECT_GT(
      (hand::actuator_positions(off.hand_model(), off.truth().joints) - drives(wanted)).norm(),
      0.03);
  EXPECT_LT((drives(read) - drives(wanted)).norm(), 0.03);
}

}  // namespace
}  // namespace palpate::simulation
