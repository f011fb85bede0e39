// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/error_message.hpp"
#include "hand/descriptions.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/tactile/biotac/fingers.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "tactile/one_link_hand.hpp"

namespace palpate::tactile {
namespace {

std::shared_ptr<const BiotacInverse> inverse() {
  static const auto model = [] {
    BiotacDatasetOptions options;
    options.trajectories = 100;
    options.seconds = 1;
    options.stride = 10;
    options.seed = 1;
    return std::make_shared<const BiotacInverse>(BiotacInverse::train(simulate_biotac(options)));
  }();
  return model;
}

const hand::TipContact kTouch{.p = {-0.003, 0, -0.007}, .n = {0, 0, 1}, .f = {0.3, 0.2, -2}};

/// A sensor that is read frame by frame, and what is sensed in it.
class Stream {
 public:
  BiotacReading read(double newtons) {
    hand::TipContact contact = kTouch;
    contact.f *= newtons / 2;
    const auto state = newtons > 0 ? skin_.press({&contact, 1}) : SkinState{};
    auto reading = sensor_.step(state);
    reading.time = 0.01 * ++frames_;
    return reading;
  }
  BiotacEstimate estimate(double newtons) { return finger.step(read(newtons)); }
  void rest(int frames = BiotacFinger::kRestFrames) {
    for (int k = 0; k < frames; ++k) finger.step(read(0));
  }
  static bool has(const BiotacEstimate& estimate, BiotacFlag flag) {
    return (estimate.flags & static_cast<unsigned>(flag)) != 0;
  }

  BiotacFinger finger{inverse()};

 private:
  BiotacSkin skin_;
  BiotacSensor sensor_{skin_, {}, RandomStream(7)};
  int frames_ = 0;
};

TEST(BiotacMount, LooksTheWayTheFingerFlexes) {
  const Eigen::Isometry3d T = biotac_mount(hand::one_link_hand(), 2);
  EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
  EXPECT_LT((T.translation() - Eigen::Vector3d(0, 0, 0.02)).norm(), 1e-12);
  EXPECT_LT((T.linear().col(0) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  const Eigen::Vector3d tip(0, 0, 0.02);
  const Eigen::Vector3d way = Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()) * tip - tip;
  EXPECT_GT(way.normalized().dot(-T.linear().col(2)), 0.99);  // the sensing side goes ahead
}

TEST(BiotacFinger, SensesATouchAfterRest) {
  Stream stream;
  EXPECT_TRUE(Stream::has(stream.estimate(0), BiotacFlag::no_rest));
  stream.rest();
  EXPECT_TRUE(Stream::has(stream.estimate(0), BiotacFlag::no_contact));
  BiotacEstimate estimate;
  for (int k = 0; k < 40; ++k) estimate = stream.estimate(2);
  ASSERT_TRUE(estimate.contact);
  EXPECT_EQ(estimate.flags, 0u);
  EXPECT_LT((estimate.contact->p - kTouch.p).norm(), 0.002);
  EXPECT_LT((estimate.contact->f - kTouch.f).norm(), 0.2);
  EXPECT_LT(angle_between_deg(estimate.contact->n, kTouch.n), 15);
  for (int k = 0; k < 40; ++k) estimate = stream.estimate(0);
  EXPECT_FALSE(estimate.contact);
}

TEST(BiotacFinger, NamesFaultyChannels) {
  const auto flagged = [](double count, BiotacFlag flag, int channel) {
    Stream stream;
    stream.rest();
    for (int k = 0; k < 20; ++k) stream.estimate(2);
    auto reading = stream.read(2);
    (channel < 0 ? reading.tdc : reading.electrodes[channel]) = count;
    const auto estimate = stream.finger.step(reading);
    EXPECT_TRUE(Stream::has(estimate, flag)) << count;
    EXPECT_FALSE(estimate.contact) << count;
  };
  for (const int channel : {-1, 0, 18}) {
    flagged(std::nan(""), BiotacFlag::missing, channel);
    flagged(4095, BiotacFlag::saturated, channel);
    flagged(0, BiotacFlag::saturated, channel);
    flagged(5000, BiotacFlag::out_of_range, channel);
    flagged(-3, BiotacFlag::out_of_range, channel);
  }
}

TEST(BiotacFinger, NamesFramesThatAreLateRepeatedOrOld) {
  Stream stream;
  stream.rest();
  for (int k = 0; k < 20; ++k) stream.estimate(2);
  const auto reading = stream.read(2);
  EXPECT_TRUE(stream.finger.step(reading).contact);
  auto again = reading;
  again.time += 0.01;
  EXPECT_TRUE(Stream::has(stream.finger.step(again), BiotacFlag::repeated));
  EXPECT_FALSE(stream.finger.step(again).contact);
  auto old = stream.read(2);
  old.time -= 0.05;
  EXPECT_TRUE(Stream::has(stream.finger.step(old), BiotacFlag::out_of_order));
  EXPECT_FALSE(stream.finger.step(old).contact);
  auto late = stream.read(2);
  late.time += 0.5;
  EXPECT_TRUE(Stream::has(stream.finger.step(late), BiotacFlag::late));
}

TEST(BiotacFinger, NamesFramesWithoutATimeAndGoesOnAfterThem) {
  Stream stream;
  stream.rest();
  for (int k = 0; k < 20; ++k) stream.estimate(2);
  for (const double time : {std::nan(""), static_cast<double>(INFINITY)}) {
    auto reading = stream.read(2);
    reading.time = time;
    const auto estimate = stream.finger.step(reading);
    EXPECT_TRUE(Stream::has(estimate, BiotacFlag::missing)) << time;
    EXPECT_FALSE(estimate.contact) << time;
    EXPECT_FALSE(estimate.pressure) << time;
    const auto next = stream.estimate(2);
    EXPECT_EQ(next.flags, 0u) << time;
    EXPECT_TRUE(next.contact) << time;
  }
  // The first frame of all may be without, too.
  Stream fresh;
  auto reading = fresh.read(0);
  reading.time = std::nan("");
  EXPECT_TRUE(Stream::has(fresh.finger.step(reading), BiotacFlag::missing));
}

TEST(BiotacFinger, DoesNotSmoothAcrossFramesThatWereLost) {
  Stream stream;
  stream.rest();
  for (int k = 0; k < 40; ++k) stream.estimate(2);
  for (int k = 0; k < 10; ++k) {  // it lets go meanwhile
    auto reading = stream.read(0);
    reading.electrodes[3] = std::nan("");
    EXPECT_FALSE(stream.finger.step(reading).pressure);
  }
  const auto estimate = stream.estimate(0);
  ASSERT_TRUE(estimate.pressure);
  EXPECT_LT(std::abs(*estimate.pressure), 8);  // twenty standard deviations of the noise
  EXPECT_FALSE(estimate.contact);
}

TEST(BiotacFinger, NoticesAStuckElectrode) {
  Stream stream;
  stream.rest();
  BiotacEstimate estimate;
  for (int k = 0; k < 80; ++k) {
    auto reading = stream.read(0.03 * k);
    reading.electrodes[16] = 3390;
    estimate = stream.finger.step(reading);
  }
  EXPECT_TRUE(Stream::has(estimate, BiotacFlag::stuck));
  EXPECT_FALSE(estimate.contact);
}

TEST(BiotacFinger, FollowsDriftAndReportsIt) {
  Stream stream;
  stream.rest();
  BiotacEstimate estimate;
  for (int k = 0; k < 1500; ++k) {
    auto reading = stream.read(0);
    reading.electrodes.array() -= std::round(0.03 * k);  // 3 counts a second
    estimate = stream.finger.step(reading);
    EXPECT_FALSE(estimate.contact);
  }
  EXPECT_TRUE(Stream::has(estimate, BiotacFlag::drifted));
}

TEST(BiotacFinger, SaysNothingOfChannelsThatNoContactExplains) {
  Stream stream;
  stream.rest();
  BiotacEstimate estimate;
  for (int k = 0; k < 20; ++k) {
    auto reading = stream.read(2);
    reading.electrodes[8] = 2500 + k % 3;  // near the touch, but far too low
    estimate = stream.finger.step(reading);
  }
  EXPECT_TRUE(Stream::has(estimate, BiotacFlag::unexplained));
  EXPECT_FALSE(estimate.contact);
}

TEST(MeetingWay, IsTheMotionBeforeTheTouch) {
  MeetingWay way;
  for (int k = 0; k < 50; ++k) {
    way.follow({0.001 * k, 0, 0}, false);
    EXPECT_FALSE(way.way());
  }
  way.follow({0.050, 0, 0}, true);
  ASSERT_TRUE(way.way());
  way.follow({0.050, 0.010, 0}, true);  // whatever it does while it touches
  EXPECT_LT((*way.way() - Eigen::Vector3d::UnitX()).norm(), 1e-9);
  way.follow({0.050, 0.010, 0}, false);
  EXPECT_FALSE(way.way());
  MeetingWay still;
  for (int k = 0; k < 50; ++k) still.follow({0, 0, 0}, false);
  still.follow({0, 0, 0}, true);
  EXPECT_FALSE(still.way());
}

/// A hand whose tips move along a way and whose first finger then senses something.
hand::HandReading reading_at(int k, const Eigen::Vector3d& way, const BiotacReading& channels) {
  hand::HandReading reading = hand::resting_reading();
  reading.time = 0.01 * k;
  reading.mount.xyz = 0.0005 * k * way;
  reading.biotacs.assign(hand::kShadowFingers, channels);
  return reading;
}

TEST(BiotacFingers, AreBluntWhereNoElectrodeMeasuresThePlace) {
  BiotacFingers fingers(hand::one_link_hand(), inverse());
  const Eigen::Vector3d way(0, 0.6, 0.8);
  Stream stream;
  hand::HandReading reading = hand::resting_reading();
  for (int k = 0; k < 80; ++k) {
    auto channels = stream.read(k < 60 ? 0 : 2);
    // Near the touch, but far too low: no contact explains that.
    if (k >= 60) channels.electrodes[8] = 2500 + k % 3;
    reading = reading_at(k, way, channels);
    fingers.infer_contacts(reading);
  }
  ASSERT_EQ(reading.contacts[1].size(), 1u);
  const hand::TipContact& blunt = reading.contacts[1][0];
  EXPECT_EQ(blunt.normal_sigma, BiotacFingers::kBluntNormal);
  EXPECT_EQ(blunt.point_sigma, BiotacFingers::kBluntPoint);
  const hand::Description hand = hand::one_link_hand();
  EXPECT_LT((blunt.n + way).norm(), 1e-6);
  EXPECT_LT((blunt.p - hand.fingers[1].tip.b - hand.fingers[1].tip.radius * way).norm(), 1e-6);
  EXPECT_NEAR(blunt.f.dot(way), 2, 0.3);
}

TEST(BiotacFingers, SenseTheSameAfterFollowing) {
  BiotacFingers asked(hand::one_link_hand(), inverse()), followed(hand::one_link_hand(), inverse());
  Stream stream;
  std::size_t contacts = 0;
  for (int k = 0; k < 80; ++k) {
    hand::HandReading a = reading_at(k, {0, 0.6, 0.8}, stream.read(k < 40 ? 0 : 2));
    hand::HandReading b = a;
    asked.infer_contacts(a);
    if (k < 60) {
      followed.follow(b);
      continue;
    }
    followed.infer_contacts(b);
    for (std::size_t i = 0; i < hand::kShadowFingers; ++i) {
      ASSERT_EQ(a.contacts[i].size(), b.contacts[i].size()) << k;
      for (std::size_t c = 0; c < a.contacts[i].size(); ++c, ++contacts) {
        EXPECT_EQ(a.contacts[i][c].p, b.contacts[i][c].p);
        EXPECT_EQ(a.contacts[i][c].n, b.contacts[i][c].n);
        EXPECT_EQ(a.contacts[i][c].f, b.contacts[i][c].f);
        EXPECT_EQ(a.contacts[i][c].point_sigma, b.contacts[i][c].point_sigma);
        EXPECT_EQ(a.contacts[i][c].normal_sigma, b.contacts[i][c].normal_sigma);
      }
    }
  }
  EXPECT_GT(contacts, 0u);
}

TEST(BiotacFingers, TellHowFarTheirContactsMayBeOff) {
  BiotacFingers fingers(hand::one_link_hand(), inverse());
  InferredContact contact;
  contact.p = {-0.003, 0, -0.007};
  contact.n = {0, 0, 1};
  contact.f = {0, 0, -1};
  contact.covariance = Eigen::Matrix<double, 5, 5>::Identity() * 4e-7;
  const double radius = hand::one_link_hand().fingers[1].tip.radius;
  const auto found = fingers.in_link(contact, 1);
  EXPECT_NEAR(found.normal_sigma, std::sqrt(4e-7) / radius, 1e-9);
  EXPECT_NEAR(found.point_sigma, 4e-7 / radius, 1e-9);  // the ball's sagitta
}

TEST(BiotacFingers, PutTheirContactsIntoTheReading) {
  BiotacFingers fingers(hand::one_link_hand(), inverse());
  Stream stream;
  hand::HandReading reading = hand::resting_reading();
  EXPECT_NE(error_message([&] { fingers.infer_contacts(reading); }).find("0 BioTacs"),
            std::string::npos);
  for (int k = 0; k < 60; ++k) {
    reading.contacts[1] = {kTouch, kTouch, kTouch};
    const auto channels = stream.read(k < 25 ? 0 : 2);
    reading.biotacs.assign(hand::kShadowFingers, channels);
    fingers.infer_contacts(reading);
  }
  ASSERT_EQ(reading.contacts[1].size(), 1u);
  const Eigen::Isometry3d T = biotac_mount(hand::one_link_hand(), 1);
  EXPECT_LT((reading.contacts[1][0].p - T * kTouch.p).norm(), 0.002);
  EXPECT_LT((reading.contacts[1][0].f - T.linear() * kTouch.f).norm(), 0.2);
}

}  // namespace
}  // namespace palpate::tactile
