// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/finger_sample.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "hand/descriptions.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"

namespace palpate::tactile {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

FingerFrame frame_at(double time, double x = 0) {
  return {.time = time,
          .contacts = {{.p = {x + time, 0, 0}, .f = {0.3, 0, -2}, .tip_normal = {{0, 0, 1}}}}};
}

TEST(SampleMaker, MergesContactsThatAreOne) {
  FingerFrame frame = frame_at(0);
  frame.contacts.push_back({.p = {0.004, 0, 0}, .f = {0, 0, -1}, .tip_normal = {{0, 0, 1}}});
  const FingerSample sample = SampleMaker().next(frame);
  EXPECT_FALSE(sample.flags.any());
  EXPECT_TRUE(sample.p.isApprox(Eigen::Vector3d(0.002, 0, 0)));
  EXPECT_TRUE(sample.f.isApprox(Eigen::Vector3d(0.3, 0, -3)));
  EXPECT_TRUE(sample.tip_normal->isApprox(Eigen::Vector3d::UnitZ()));
}

TEST(SampleMaker, FramesInTimeAreNotFlagged) {
  SampleMaker maker;
  for (int i = 0; i < 100; ++i) {
    const auto sample = maker.next(frame_at(0.01 * i));
    EXPECT_FALSE(sample.flags.any()) << i << ": " << sample.flags.names();
  }
}

TEST(SampleMaker, MissingFramesLeaveAGap) {
  SampleMaker maker;
  maker.next(frame_at(0));
  const auto sample = maker.next(frame_at(0.05));
  EXPECT_EQ(sample.flags.names(), "gap");
  EXPECT_TRUE(sample.flags.usable());
}

TEST(SampleMaker, ALateFrameIsFlaggedAndUsable) {
  SampleMaker maker;
  maker.next(frame_at(0));
  const auto sample = maker.next(frame_at(0.014));
  EXPECT_EQ(sample.flags.names(), "late");
  EXPECT_TRUE(sample.flags.usable());
}

TEST(SampleMaker, RepeatedFramesAreOfNoUse) {
  SampleMaker maker;
  maker.next(frame_at(0));
  EXPECT_EQ(maker.next(frame_at(0, 0.001)).flags.names(), "repeated");  // same time
  FingerFrame stuck = frame_at(0, 0.001);
  stuck.time = 0.01;  // same contacts
  const auto sample = maker.next(stuck);
  EXPECT_EQ(sample.flags.names(), "repeated");
  EXPECT_FALSE(sample.flags.usable());
  EXPECT_TRUE(std::isnan(sample.p.x()));
}

TEST(SampleMaker, AFrameOutOfOrderIsOfNoUseAndDoesNotTurnBackTheClock) {
  SampleMaker maker;
  maker.next(frame_at(0.02));
  EXPECT_EQ(maker.next(frame_at(0.01)).flags.names(), "out_of_order");
  EXPECT_FALSE(maker.next(frame_at(0.03)).flags.any());
}

/// Flags of frames at these times, each with contacts of its own.
std::vector<std::string> flags_at(const std::vector<double>& times) {
  SampleMaker maker;
  std::vector<std::string> flags;
  for (std::size_t i = 0; i < times.size(); ++i) {
    flags.push_back(maker.next(frame_at(times[i], 1e-4 * static_cast<double>(i))).flags.names());
  }
  return flags;
}

TEST(SampleMaker, AClockThatWasSetBackOrOneFrameAheadLosesFourFrames) {
  const std::string lost = "out_of_order";
  const auto set_back = flags_at({10, 10.01, 8, 8.01, 8.02, 8.03, 8.04, 8.05, 8.06});
  EXPECT_EQ(set_back, (std::vector<std::string>{"", "", lost, lost, lost, lost, "gap", "", ""}));
  const auto ahead = flags_at({0, 0.01, 999, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08});
  EXPECT_EQ(ahead, (std::vector<std::string>{"", "", "gap", lost, lost, lost, lost, "gap", ""}));
}

TEST(SampleMaker, OldFramesThatDoNotFollowEachOtherAreNoNewClock) {
  const auto mixed = flags_at({10, 8, 7, 8, 7, 8, 7, 8, 7, 10.01});
  EXPECT_EQ(std::count(mixed.begin(), mixed.end(), "out_of_order"), 8);
  EXPECT_EQ(mixed.back(), "");
  const auto old = flags_at({10, 1, 2, 3, 4, 5, 6, 7, 10.01});
  EXPECT_EQ(std::count(old.begin(), old.end(), "out_of_order"), 7);
}

TEST(SampleMaker, AFingerThatPressesNothingIsNotCalledRepeated) {
  SampleMaker maker;
  FingerFrame frame = frame_at(0);
  frame.contacts[0].f.setZero();
  for (int i = 0; i < 3; ++i) {
    frame.time = 0.01 * i;
    EXPECT_EQ(maker.next(frame).flags.names(), "no_force") << i;
  }
}

TEST(SampleMaker, PlaceholdersAreOfNoUse) {
  FingerFrame frame;
  frame.contacts = {{.p = {0, 0, 0}, .f = {0, -1, 0}, .tip_normal = {}}};
  const auto sample = SampleMaker().next(frame);
  EXPECT_EQ(sample.flags.names(), "placeholder");
  EXPECT_FALSE(sample.flags.usable());
  EXPECT_TRUE(std::isnan(sample.f.x()));
}

TEST(SampleMaker, APlaceholderBesideAContactIsLeftOutAndFlagged) {
  FingerFrame frame = frame_at(0);
  frame.contacts.push_back({.p = {1, 1, 1}, .f = {0, -1, 0}, .tip_normal = {}});
  const auto sample = SampleMaker().next(frame);
  EXPECT_EQ(sample.flags.names(), "left_out");
  EXPECT_TRUE(sample.flags.usable());
  EXPECT_TRUE(sample.p.isZero());
  EXPECT_TRUE(sample.f.isApprox(frame.contacts[0].f));
}

TEST(SampleMaker, ZeroForcesAreOfNoUse) {
  FingerFrame frame = frame_at(0);
  frame.contacts[0].f.setZero();
  EXPECT_EQ(SampleMaker().next(frame).flags.names(), "no_force");
}

TEST(SampleMaker, ForcesThatCancelAreOfNoUse) {
  FingerFrame frame = frame_at(0);
  frame.contacts.push_back(frame.contacts[0]);
  frame.contacts[1].p.x() += 0.001;
  frame.contacts[1].f *= -1;
  const auto sample = SampleMaker().next(frame);
  EXPECT_TRUE(sample.flags.has(SampleFlag::no_force));
  EXPECT_FALSE(sample.flags.usable());
}

TEST(SampleMaker, ValuesThatAreNotFiniteAreOfNoUse) {
  for (int which = 0; which < 4; ++which) {
    FingerFrame frame = frame_at(0);
    if (which == 0) frame.contacts[0].p.y() = kNan;
    if (which == 1) frame.contacts[0].f.z() = std::numeric_limits<double>::infinity();
    if (which == 2) frame.contacts[0].tip_normal = Eigen::Vector3d(kNan, 0, 1);
    if (which == 3) frame.time = kNan;
    const auto sample = SampleMaker().next(frame);
    EXPECT_EQ(sample.flags.names(), "not_finite") << which;
    EXPECT_FALSE(sample.flags.usable()) << which;
  }
}

TEST(SampleMaker, AFingerInNoContactIsFlagged) {
  const auto sample = SampleMaker().next({.time = 0, .contacts = {}});
  EXPECT_EQ(sample.flags.names(), "no_contact");
  EXPECT_FALSE(sample.flags.usable());
}

TEST(SampleMaker, TwoContactsFarApartAreNotAveraged) {
  FingerFrame frame = frame_at(0);
  frame.contacts.push_back({.p = {0.012, 0, 0}, .f = {0, 0, -1}, .tip_normal = {{0, 0, 1}}});
  const auto sample = SampleMaker().next(frame);
  EXPECT_EQ(sample.flags.names(), "far_apart");
  EXPECT_FALSE(sample.flags.usable());
}

TEST(SampleMaker, TwoFacesAtOnePlaceAreNotAveraged) {
  FingerFrame frame = frame_at(0);
  frame.contacts.push_back({.p = {0.003, 0, 0}, .f = {-1, 0, 0}, .tip_normal = {{1, 0, 0}}});
  EXPECT_EQ(SampleMaker().next(frame).flags.names(), "far_apart");
}

TEST(SampleMaker, RefusesOptionsOutOfRange) {
  EXPECT_THROW(SampleMaker({.period = 0}), BadInput);
  EXPECT_THROW(SampleMaker({.period = kNan}), BadInput);
  EXPECT_THROW(SampleMaker({.one_contact = -1}), BadInput);
  EXPECT_THROW(SampleMaker({.one_direction = kNan}), BadInput);
}

TEST(FingerFrame, HasTheCapsulesNormalInTheWorld) {
  hand::Description hand = hand::shadow_on_link(
      0, {.a = Eigen::Vector3d::Zero(), .b = Eigen::Vector3d(0, 0, 0.02), .radius = 0.007});
  hand.links.resize(1);
  hand::HandReading reading = hand::resting_reading();
  reading.mount.xyz = {1, 2, 3};
  reading.mount.ypr = {0.3, -0.7, 1.1};
  // Beside the axis, and beyond its end.
  reading.contacts[1] = {{.p = {0.007, 0, 0.01}, .n = {-1, 0, 0}, .f = {1, 0, 0}},
                         {.p = {0, 0, 0.027}, .n = {0, 0, -1}, .f = {0, 0, 2}}};
  const FingerFrame frame = finger_frame(reading, hand, 1);
  ASSERT_EQ(frame.contacts.size(), 2u);
  const Eigen::Isometry3d T = reading.mount.pose();
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& sensed = reading.contacts[1][i];
    EXPECT_TRUE(frame.contacts[i].p.isApprox(T * sensed.p));
    EXPECT_TRUE(frame.contacts[i].f.isApprox(T.linear() * sensed.f));
    ASSERT_TRUE(frame.contacts[i].tip_normal);
    EXPECT_TRUE(frame.contacts[i].tip_normal->isApprox(T.linear() * sensed.n, 1e-9));
  }
  EXPECT_TRUE(finger_frame(reading, hand, 2).contacts.empty());
}

}  // namespace
}  // namespace palpate::tactile
