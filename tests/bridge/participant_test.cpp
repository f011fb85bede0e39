// SPDX-License-Identifier: Apache-2.0
#include "palpate/bridge/participant.hpp"

#include <vector>

#include "bridge/bridge_fixture.hpp"
#include "palpate/core/error.hpp"
#include "palpate/ros2/cdr.hpp"
#include "palpate/ros2/messages/std_msgs.hpp"

namespace palpate::bridge {
namespace {

using ParticipantTest = DdsTest;
using ros2::String;

std::vector<std::string> wait_for(Participant& participant, RawReader& reader, std::size_t count) {
  std::vector<std::string> texts;
  for (int i = 0; i < 600 && texts.size() < count; ++i) {
    participant.wait(0.1);
    reader.take([&](std::string_view cdr, std::uint64_t received) {
      EXPECT_GT(received, 0U);
      texts.push_back(ros2::deserialize<String>(cdr).data);
    });
  }
  return texts;
}

void wait_for_reader(const RawWriter& writer) {
  for (int i = 0; i < 6000 && writer.readers() == 0; ++i) usleep(10000);
}

TEST_F(ParticipantTest, MessagesOfAllSizesArriveInOrder) {
  Participant one(domain_), other(domain_);
  TopicWriter<String> writer(one, "/text");
  RawReader reader(other, "/text", String::kType, {});
  wait_for_reader(writer);
  const std::vector<std::string> sent = {"a",
                                         "",
                                         std::string(1000, 'x'),
                                         std::string(300000, 'y'),
                                         "ends oddly 1",
                                         "ends oddly 12",
                                         "ends oddly 123"};
  for (const auto& text : sent) EXPECT_TRUE(writer.write(String{text}));
  EXPECT_EQ(wait_for(other, reader, sent.size()), sent);
  EXPECT_EQ(reader.lost(), 0U);
  EXPECT_EQ(writer.written(), sent.size());
}

TEST_F(ParticipantTest, WhatIsLatchedReachesWhoComesLater) {
  Participant one(domain_), other(domain_);
  const Qos latched{.reliable = true, .latched = true, .depth = 1};
  TopicWriter<String> writer(one, "/latched", latched);
  writer.write(String{"first"});
  writer.write(String{"last"});
  RawReader reader(other, "/latched", String::kType, latched);
  EXPECT_EQ(wait_for(other, reader, 1), std::vector<std::string>{"last"});
}

TEST_F(ParticipantTest, AnotherTypeIsNotHeard) {
  Participant one(domain_), other(domain_);
  TopicWriter<String> writer(one, "/mixed");
  RawReader wrong(other, "/mixed", "std_msgs/msg/Header", {});
  RawReader right(other, "/other", String::kType, {});
  TopicWriter<String> later(one, "/other");
  wait_for_reader(later);
  EXPECT_EQ(writer.readers(), 0);
}

TEST_F(ParticipantTest, ADomainMustBeOne) {
  EXPECT_THROW(Participant(1000), BadInput);
  setenv("ROS_DOMAIN_ID", "7", 1);
  EXPECT_EQ(default_domain(), 7);
  for (const char* wrong : {"x", "-1", "233", "7 "}) {
    setenv("ROS_DOMAIN_ID", wrong, 1);
    EXPECT_THROW(default_domain(), BadInput) << wrong;
  }
  unsetenv("ROS_DOMAIN_ID");
  EXPECT_EQ(default_domain(), 0);
}

}  // namespace
}  // namespace palpate::bridge
