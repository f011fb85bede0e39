// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/reading_stream.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/ros2/cdr.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::uint64_t kMillisecond = 1'000'000, kSecond = 1'000'000'000;

/// A hand that publishes, as messages_of() has it.
class StreamTest : public testing::Test {
 protected:
  hand::Description hand_ = recording::toy_hand();
  RobotInterface interface_;
  ReadingStream stream_{hand_, interface_};
  hand::HandReading reading_ = hand::resting_reading(hand_);

  template <Message M>
  std::optional<hand::HandReading> send(const std::string& topic, const M& message,
                                        std::uint64_t received = 0) {
    return stream_.take(topic, M::kType, serialize(message), received);
  }

  std::optional<hand::HandReading> send_all(std::uint64_t time) {
    const auto messages = messages_of(reading_, hand_, interface_, time);
    send(interface_.tf, messages.tf);
    for (std::size_t i = 0; i < hand_.fingers.size(); ++i) {
      send(interface_.contacts_of(hand_.fingers[i]), messages.contacts[i]);
    }
    send(interface_.wrench, messages.wrench);
    send(interface_.actuator_states, messages.actuators);
    return send(interface_.joint_states, messages.joints);
  }
};

TEST_F(StreamTest, ContactsFarFromTheirFingertipAreDropped) {
  reading_.contacts[2] = {{{0.001, 0, 0.01}, {0, 0, 1}, {0, 0, -1}}};
  const auto near = send_all(kSecond);
  ASSERT_TRUE(near);
  EXPECT_EQ(near->contacts[2].size(), 1u);
  reading_.contacts[2][0].p.x() = 5;
  const auto far = send_all(kSecond + 500 * kMillisecond);
  ASSERT_TRUE(far);
  EXPECT_TRUE(far->contacts[2].empty());
  EXPECT_EQ(stream_.counts().malformed, 1u);
  EXPECT_NE(stream_.counts().last_error.find("distance of a contact"), std::string::npos);
}

TEST_F(StreamTest, AReadingComesBack) {
  RandomStream random(1, "stream");
  reading_ = recording::toy_frame(hand_, 3, random).reading;
  reading_.contacts[2] = {{{0.001, 0.002, 0.003}, {0, 0, 1}, {0, 0.25, -2}, 0.0005, 0.125}};
  const auto read = send_all(7 * kSecond);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->time, 0);
  EXPECT_EQ(stream_.start(), 7 * kSecond);
  EXPECT_TRUE(read->joints == reading_.joints);
  EXPECT_TRUE(read->torques == reading_.torques);
  EXPECT_TRUE(read->mount_force.isApprox(reading_.mount_force, 1e-12));
  EXPECT_TRUE(read->mount.pose().isApprox(reading_.mount.pose(), 1e-9));
  for (std::size_t i = 0; i < hand_.fingers.size(); ++i) {
    ASSERT_EQ(read->contacts[i].size(), reading_.contacts[i].size());
  }
  const auto& contact = read->contacts[2].at(0);
  EXPECT_TRUE(contact.p.isApprox(reading_.contacts[2][0].p, 1e-6));
  EXPECT_EQ(contact.n, reading_.contacts[2][0].n);
  EXPECT_EQ(contact.f, reading_.contacts[2][0].f);
  EXPECT_FLOAT_EQ(static_cast<float>(contact.point_sigma), 0.0005F);
  EXPECT_EQ(contact.normal_sigma, 0.125);
}

TEST_F(StreamTest, AWrenchOnAFingertipIsTheContactThatExplainsIt) {
  const auto& finger = hand_.fingers[1];
  const Eigen::Vector3d f(0, 0, -3);  // of the object on the tip
  const Eigen::Vector3d p = finger.tip.b + Eigen::Vector3d(0, 0, finger.tip.radius);
  const Eigen::Vector3d m = p.cross(f);
  WrenchStamped message;
  message.header = {stamp_of(kSecond), tip_frame(hand_, finger)};
  message.wrench = {{f.x(), f.y(), f.z()}, {m.x(), m.y(), m.z()}};
  const auto messages = messages_of(reading_, hand_, interface_, kSecond);
  send(interface_.tf, messages.tf);
  send(interface_.fingertip_wrench_of(finger), message);
  const auto read = send(interface_.joint_states, messages.joints);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->contacts[1].size(), 1U);
  EXPECT_TRUE(read->contacts[1][0].f.isApprox(-f));
  EXPECT_GT(read->contacts[1][0].point_sigma, 0);

  message.header.frame_id = "elsewhere";
  send(interface_.fingertip_wrench_of(finger), message);
  message.header.frame_id = tip_frame(hand_, finger);
  message.wrench.torque.x = std::numeric_limits<double>::quiet_NaN();
  send(interface_.fingertip_wrench_of(finger), message);
  EXPECT_EQ(stream_.counts().malformed, 2U);
}

TEST_F(StreamTest, OneKilohertzGivesOneReadingATick) {
  std::vector<double> times;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    if (const auto reading = send_all(kSecond + i * kMillisecond)) times.push_back(reading->time);
  }
  EXPECT_EQ(stream_.counts().joint_states, 1000U);
  ASSERT_NEAR(static_cast<double>(times.size()), 100, 1);
  for (std::size_t i = 2; i < times.size(); ++i) EXPECT_NEAR(times[i] - times[i - 1], 0.01, 1e-9);
}

TEST_F(StreamTest, LateAndRepeatedMessagesAreDroppedAndCounted) {
  send_all(kSecond);
  send_all(kSecond + 20 * kMillisecond);
  EXPECT_EQ(stream_.counts().out_of_order, 0U);
  EXPECT_FALSE(send_all(kSecond + 10 * kMillisecond));
  EXPECT_FALSE(send_all(kSecond + 20 * kMillisecond));
  EXPECT_GE(stream_.counts().out_of_order, 4U);
  EXPECT_EQ(stream_.counts().readings, 2U);
}

TEST(LatestTime, ManyEarlyOnesInARowAreOfAClockThatWasSetBack) {
  LatestTime latest;
  EXPECT_EQ(latest.take(5 * kSecond), TimeOrder::later);
  for (int i = 0; i < 100; ++i) {  // one that stands still, and jitter
    EXPECT_EQ(latest.take(kSecond), TimeOrder::late);
    EXPECT_EQ(latest.take(5 * kSecond - static_cast<std::uint64_t>(i)), TimeOrder::late);
  }
  std::uint64_t early = 2 * kSecond;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(latest.take(early++), TimeOrder::late);
  EXPECT_EQ(latest.take(6 * kSecond), TimeOrder::later);  // two senders, of which one is late
  for (int i = 0; i < 19; ++i) EXPECT_EQ(latest.take(early++), TimeOrder::late);
  EXPECT_EQ(latest.take(early), TimeOrder::set_back);
  EXPECT_EQ(latest.time(), early);
  EXPECT_EQ(latest.take(early + 1), TimeOrder::later);
}

TEST_F(StreamTest, ASenderWhoseClockIsSetBackIsTakenUpAgain) {
  for (std::uint64_t i = 0; i < 30; ++i) send_all(1000 * kSecond + 10 * i * kMillisecond);
  EXPECT_EQ(stream_.counts().readings, 30U);
  std::vector<hand::HandReading> after;
  for (std::uint64_t i = 1; i <= 50; ++i) {  // as a simulation that begins again, or a bag
    if (auto reading = send_all(10 * i * kMillisecond)) after.push_back(std::move(*reading));
  }
  EXPECT_EQ(stream_.counts().restarts, 1U);
  ASSERT_GE(after.size(), 29U);
  EXPECT_EQ(after[0].time, 0);
  EXPECT_NEAR(after[1].time, hand::kTick, 1e-9);
  EXPECT_LT(*stream_.start(), kSecond);
  EXPECT_EQ(stream_.counts().gaps, 0U);
}

TEST_F(StreamTest, AMessageFromTheFarFutureEndsNothing) {
  send_all(kSecond);
  send_all(4'000 * kSecond);
  std::uint64_t readings = stream_.counts().readings;
  for (std::uint64_t i = 2; i < 102; ++i) send_all(kSecond + 10 * i * kMillisecond);
  EXPECT_GE(stream_.counts().readings, readings + 79);
}

TEST_F(StreamTest, WhatOthersOfTheRobotTellHarmsNothing) {
  auto messages = messages_of(reading_, hand_, interface_, kSecond);
  messages.joints.name.insert(messages.joints.name.begin(), {"wheel", "gripper"});
  messages.joints.position.insert(messages.joints.position.begin(), {123456.7, std::nan("")});
  auto& transforms = messages.tf.transforms;
  transforms.insert(transforms.begin(), transforms[0]);
  transforms[0].child_frame_id = "camera";
  transforms[0].transform.rotation = {0, 0, 0, 0};
  send(interface_.tf, messages.tf);
  EXPECT_TRUE(send(interface_.joint_states, messages.joints));
  EXPECT_EQ(stream_.counts().malformed, 1U);  // the camera's place
}

TEST_F(StreamTest, WhatCannotBeIsDropped) {
  send_all(kSecond);
  JointState state = messages_of(reading_, hand_, interface_, 2 * kSecond).joints;
  state.position.pop_back();
  send(interface_.joint_states, state);
  state.position.push_back(std::numeric_limits<double>::quiet_NaN());
  send(interface_.joint_states, state);
  EXPECT_FALSE(stream_.take(interface_.joint_states, JointState::kType, "no cdr", 0));
  PointCloud2 cloud = cloud_of({{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}}}, {{3, 0}, "elsewhere"});
  send(interface_.contacts_of(hand_.fingers[0]), cloud);
  cloud.header.frame_id = tip_frame(hand_, hand_.fingers[0]);
  cloud.data.pop_back();
  send(interface_.contacts_of(hand_.fingers[0]), cloud);
  TFMessage tf = messages_of(reading_, hand_, interface_, 2 * kSecond).tf;
  tf.transforms[0].transform.rotation = {0, 0, 0, 0};
  send(interface_.tf, tf);
  EXPECT_EQ(stream_.counts().malformed, 6U);
  EXPECT_EQ(stream_.counts().readings, 1U);
  EXPECT_NE(stream_.counts().last_error.find("quaternion"), std::string::npos);
}

TEST_F(StreamTest, WithoutThePlaceOfTheMountThereIsNoReading) {
  const auto messages = messages_of(reading_, hand_, interface_, kSecond);
  EXPECT_FALSE(send(interface_.joint_states, messages.joints));
  EXPECT_EQ(stream_.counts().incomplete, 1U);
  send_all(2 * kSecond);
  // The sender of transforms and contacts dies, that of the joints does not.
  auto later = messages_of(reading_, hand_, interface_, 3 * kSecond).joints;
  EXPECT_FALSE(send(interface_.joint_states, later));
  EXPECT_EQ(stream_.counts().gaps, 2U);
  // It comes back.
  EXPECT_TRUE(send_all(4 * kSecond));
}

TEST_F(StreamTest, AMountMayStandStillOnAnArm) {
  const Eigen::Isometry3d up(Eigen::Translation3d(0, 0, 0.5)),
      along(Eigen::Translation3d(0.1, 0, 0));
  send(interface_.tf_static, TFMessage{{transform_stamped({1, 0}, "arm", "mount", along)}});
  send(interface_.tf_static, TFMessage{{transform_stamped({1, 0}, "world", "arm", up)}});
  const auto joints = messages_of(reading_, hand_, interface_, 1000 * kSecond).joints;
  const auto reading = send(interface_.joint_states, joints);
  ASSERT_TRUE(reading);
  EXPECT_TRUE(reading->mount.xyz.isApprox(Eigen::Vector3d(0.1, 0, 0.5)));
  EXPECT_TRUE(reading->contacts[0].empty());
}

TEST_F(StreamTest, TransformsInACircleEnd) {
  const auto none = Eigen::Isometry3d::Identity();
  send(interface_.tf_static, TFMessage{{transform_stamped({1, 0}, "a", "mount", none)}});
  send(interface_.tf_static, TFMessage{{transform_stamped({1, 0}, "mount", "a", none)}});
  EXPECT_FALSE(
      send(interface_.joint_states, messages_of(reading_, hand_, interface_, kSecond).joints));
}

TEST_F(StreamTest, JointsMayComeInParts) {
  const auto messages = messages_of(reading_, hand_, interface_, kSecond);
  send(interface_.tf, messages.tf);
  JointState first = messages.joints, second = messages.joints;
  first.name.resize(5);
  first.position.resize(5);
  second.name.erase(second.name.begin(), second.name.begin() + 5);
  second.position.erase(second.position.begin(), second.position.begin() + 5);
  EXPECT_FALSE(send(interface_.joint_states, first));
  EXPECT_TRUE(send(interface_.joint_states, second));
  JointState arm;
  arm.header.stamp = {9, 0};
  arm.name = {"arm_1"};
  arm.position = {1};
  EXPECT_FALSE(send(interface_.joint_states, arm));
  EXPECT_EQ(stream_.counts().out_of_order, 0U);
}

TEST_F(StreamTest, RawValuesOfTaxelsAreContacts) {
  const auto& thumb = hand_.fingers[0].name;
  interface_.taxel_layout[thumb] = {{{0.01, 0, 0}, {1, 0, 0}, 0.01, 100},
                                    {{0, 0.01, 0}, {0, 1, 0}}};
  ReadingStream stream(hand_, interface_);
  const auto messages = messages_of(reading_, hand_, interface_, kSecond);
  const auto take = [&](const auto& topic, const auto& message) {
    return stream.take(topic, std::decay_t<decltype(message)>::kType, serialize(message), 5);
  };
  take(interface_.tf, messages.tf);
  take(interface_.joint_states, messages.joints);
  const auto topic = interface_.taxels_of(hand_.fingers[0]);
  take(topic, Float32MultiArray{{}, {350, 0.01F}});
  const auto at = [&](std::uint64_t time) {
    return take(interface_.joint_states, messages_of(reading_, hand_, interface_, time).joints);
  };
  auto reading = at(kSecond + 20 * kMillisecond);
  ASSERT_TRUE(reading);
  ASSERT_EQ(reading->contacts[0].size(), 1U);
  EXPECT_EQ(reading->contacts[0][0].p, Eigen::Vector3d(0.01, 0, 0));
  EXPECT_EQ(reading->contacts[0][0].n, Eigen::Vector3d(-1, 0, 0));  // outward of the object
  EXPECT_TRUE(reading->contacts[0][0].f.isApprox(Eigen::Vector3d(2.5, 0, 0)));
  EXPECT_GT(reading->contacts[0][0].point_sigma, 0);
  take(topic, Float64MultiArray{{}, {100, 3}});
  reading = at(kSecond + 40 * kMillisecond);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->contacts[0].at(0).p, Eigen::Vector3d(0, 0.01, 0));

  // What cannot be is counted and dropped; what no longer comes, no longer counts.
  take(topic, Float64MultiArray{{}, {100}});
  take(topic, Float64MultiArray{{}, {std::nan(""), 0}});
  take(topic, Float32MultiArray{{}, {1e20F, 0}});
  EXPECT_EQ(stream.counts().malformed, 3U);
  EXPECT_EQ(stream.counts().contacts, 2U);
  take(interface_.tf, messages_of(reading_, hand_, interface_, 9 * kSecond).tf);
  reading = at(9 * kSecond);
  ASSERT_TRUE(reading);
  EXPECT_TRUE(reading->contacts[0].empty());
  interface_.taxel_layout["tail"] = {};
  EXPECT_THROW(ReadingStream(hand_, interface_), BadInput);
}

TEST(Cloud, TakesOtherLayoutsAndNoNormals) {
  PointCloud2 cloud;
  cloud.height = 1;
  cloud.width = 2;
  cloud.point_step = 28;
  cloud.row_step = 56;
  cloud.point_fields = {{"ring", 0, 2, 1},
                        {"z", 20, PointField::kFloat64, 1},
                        {"y", 12, PointField::kFloat64, 1},
                        {"x", 4, PointField::kFloat64, 1}};
  cloud.data.resize(56);
  const std::array<double, 3> first = {0.5, 0.25, 0.125}, second = {0, 0, std::nan("")};
  std::memcpy(&cloud.data[4], first.data(), sizeof first);
  std::memcpy(&cloud.data[32], second.data(), sizeof second);
  const auto contacts = contacts_of(cloud);
  ASSERT_EQ(contacts.size(), 1U);  // the other is not finite
  EXPECT_EQ(contacts[0].p, Eigen::Vector3d(0.5, 0.25, 0.125));
  EXPECT_TRUE(contacts[0].n.isZero(0));
  cloud.point_fields[1].offset = 21;
  EXPECT_THROW(contacts_of(cloud), BadInput);
  cloud.point_fields.pop_back();
  EXPECT_THROW(contacts_of(cloud), BadInput);
  EXPECT_TRUE(contacts_of(PointCloud2{}).empty());
}

TEST(Estimate, CovarianceIsInTheOrderOfRos) {
  localization::Posterior posterior;
  posterior.status = localization::PoseStatus::certain;
  posterior.modes.resize(1);
  for (int i = 0; i < 36; ++i) posterior.modes[0].covariance(i / 6, i % 6) = i;
  const auto messages =
      messages_of(posterior, {}, {Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)}, {}, 5);
  const auto& covariance = messages.pose.at(0).pose.covariance;
  EXPECT_EQ(covariance[0], posterior.modes[0].covariance(3, 3));          // x with x
  EXPECT_EQ(covariance[6 * 1 + 5], posterior.modes[0].covariance(4, 2));  // y with yaw
  EXPECT_EQ(messages.status.data, "certain");
  EXPECT_TRUE(messages_of({}, {}, {}, {}, 5).pose.empty());
}

// About a vertical line 0.3 m before the origin in x.
TEST(Estimate, CovarianceHasTheWholeFreeTurn) {
  localization::Posterior posterior;
  posterior.modes.resize(1);
  posterior.modes[0].covariance.diagonal().setConstant(1e-4);
  posterior.modes[0].free_axis = {Eigen::Vector3d(0.3, 0, 0), Eigen::Vector3d::UnitZ(), M_PI};
  const auto messages =
      messages_of(posterior, {}, {Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(1, 1, 1)}, {}, 5);
  const auto& covariance = messages.pose.at(0).pose.covariance;
  const double turn = M_PI * M_PI / 3;
  EXPECT_NEAR(covariance[6 * 5 + 5], turn, 1e-9);         // yaw
  EXPECT_NEAR(covariance[6 * 3 + 3], 1e-4, 1e-9);         // roll
  EXPECT_NEAR(covariance[6 * 1 + 5], -0.3 * turn, 1e-3);  // y with yaw
}

}  // namespace
}  // namespace palpate::ros2
