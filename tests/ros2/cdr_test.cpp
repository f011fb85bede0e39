// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/cdr.hpp"

#include <gtest/gtest.h>

#include "palpate/core/random.hpp"
#include "palpate/ros2/messages/diagnostic_msgs.hpp"
#include "palpate/ros2/messages/sensor_msgs.hpp"
#include "palpate/ros2/messages/trajectory_msgs.hpp"
#include "palpate/ros2/messages/visualization_msgs.hpp"
#include "palpate/ros2/schema.hpp"

namespace palpate::ros2 {
namespace {

/// A joint state byte by byte, as the specification has it: OMG CDR, little endian, after the
/// encapsulation header, alignment counted from behind that.
const std::string kJointState(
    "\x00\x01\x00\x00"                  // plain CDR, little endian
    "\x07\x00\x00\x00\x09\x00\x00\x00"  // stamp
    "\x02\x00\x00\x00"                  // "m", with its zero
    "m\x00\x00\x00"                     // padded to 4
    "\x01\x00\x00\x00\x04\x00\x00\x00"
    "FFJ\x00"                            // one name
    "\x01\x00\x00\x00"                   // one position,
    "\x00\x00\x00\x00\x00\x00\xf8\x3f"   // aligned to 8: 1.5
    "\x00\x00\x00\x00\x00\x00\x00\x00",  // no velocity, no effort
    4 + 8 + 8 + 12 + 4 + 8 + 8);

JointState joint_state() {
  JointState state;
  state.header = {{7, 9}, "m"};
  state.name = {"FFJ"};
  state.position = {1.5};
  return state;
}

TEST(Cdr, IsThatOfTheSpecification) {
  EXPECT_EQ(serialize(joint_state()), kJointState);
  const auto read = deserialize<JointState>(kJointState);
  EXPECT_EQ(read.header.stamp.sec, 7);
  EXPECT_EQ(read.header.stamp.nanosec, 9U);
  EXPECT_EQ(read.header.frame_id, "m");
  EXPECT_EQ(read.name, std::vector<std::string>{"FFJ"});
  EXPECT_EQ(read.position, std::vector<double>{1.5});
  EXPECT_TRUE(read.effort.empty());
}

TEST(Cdr, EveryFieldComesBack) {
  MarkerArray array;
  array.markers.resize(2);
  Marker& marker = array.markers[1];
  marker.header = {{-1, 5}, "world"};
  marker.ns = "a\0b";
  marker.type = Marker::kCube;
  marker.color = {0.25F, 0.5F, 0.75F, 1};
  marker.points = {{1, 2, 3}, {4, 5, 6}};
  marker.colors = {{1, 0, 0, 1}};
  marker.uv_coordinates = {{0.5F, 0.25F}};
  marker.mesh_file = {"f", {1, 2, 3}};
  marker.frame_locked = marker.mesh_use_embedded_materials = true;
  EXPECT_EQ(serialize(deserialize<MarkerArray>(serialize(array))), serialize(array));
  DiagnosticArray diagnostics;
  diagnostics.status = {{DiagnosticStatus::kError, "n", "m", "h", {{"k", "v"}}}};
  const auto read = deserialize<DiagnosticArray>(serialize(diagnostics));
  EXPECT_EQ(read.status.at(0).level, DiagnosticStatus::kError);
  EXPECT_EQ(read.status.at(0).values.at(0).value, "v");
}

TEST(Cdr, EveryShorterMessageIsRefused) {
  for (std::size_t size = 0; size < kJointState.size(); ++size) {
    EXPECT_THROW(deserialize<JointState>(std::string_view(kJointState).substr(0, size)), BadInput)
        << size;
  }
  EXPECT_THROW(deserialize<JointState>(kJointState + std::string(8, '\0')), BadInput);
}

TEST(Cdr, LengthsThatTheBytesCannotHoldAllocateNothing) {
  CdrWriter writer;
  writer.put(std::uint32_t{0xffffffff});  // so many transforms
  EXPECT_THROW(deserialize<MarkerArray>(writer.take()), BadInput);
  std::string big_endian = kJointState;
  big_endian[1] = 0;
  EXPECT_THROW(deserialize<JointState>(big_endian), BadInput);
}

TEST(Cdr, ChangedBytesAreReadOrRefused) {
  RandomStream random(3, "cdr");
  const std::string whole = serialize(joint_state());
  int read = 0, refused = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = whole;
    for (std::size_t k = 0; k <= random.index(3); ++k) {
      bytes[random.index(bytes.size())] = static_cast<char>(random.index(256));
    }
    try {
      deserialize<JointState>(bytes);
      ++read;
    } catch (const BadInput&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 1000);
  EXPECT_GT(refused, 1000);
}

TEST(Schema, HasEveryTypeOnce) {
  EXPECT_EQ(message_schema<Time>(), "int32 sec\nuint32 nanosec\n");
  const std::string line(80, '=');
  EXPECT_EQ(message_schema<JointTrajectory>(),
            "std_msgs/Header header\nstring[] joint_names\n"
            "trajectory_msgs/JointTrajectoryPoint[] points\n" +
                line + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" +
                line + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + line +
                "\nMSG: trajectory_msgs/JointTrajectoryPoint\nfloat64[] positions\n"
                "float64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
                "builtin_interfaces/Duration time_from_start\n" +
                line + "\nMSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n");
  EXPECT_NE(message_schema<PoseWithCovarianceStamped>().find("float64[36] covariance"),
            std::string::npos);
  EXPECT_NE(message_schema<DiagnosticArray>().find("byte level"), std::string::npos);
}

TEST(Schema, NamesOnDds) {
  EXPECT_EQ(dds_type_name("sensor_msgs/msg/JointState"), "sensor_msgs::msg::dds_::JointState_");
  EXPECT_EQ(dds_topic_name("/joint_states"), "rt/joint_states");
}

}  // namespace
}  // namespace palpate::ros2
