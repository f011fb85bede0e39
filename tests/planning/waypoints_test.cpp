// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/waypoints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/error_message.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "planning/motions.hpp"

namespace palpate::planning {
namespace {

using ::testing::Test;

std::string header() { return fmt::format("{}", fmt::join(hand::kShadowJointNames, ",")); }

std::string row(double value, int count = hand::kShadowJoints) {
  return fmt::format("{}",
                     fmt::join(std::vector<double>(static_cast<std::size_t>(count), value), ","));
}

TEST(Waypoints, ColumnsAreFoundByTheirNames) {
  std::string names = header();
  names.replace(names.find("WRJ2"), 9, "WRJ1,WRJ2");
  const auto file = parse_waypoints(names + "\n1,2" + row(0).substr(3) + "\n\n" + row(0) + "\n",
                                    "q.csv", {}, hand::shadow_hand());
  ASSERT_EQ(file.waypoints.size(), 2U);
  EXPECT_FALSE(file.has_mount);
  EXPECT_EQ(file.waypoints[0].joints[hand::shadow_hand().joint("WRJ1")], 1);
  EXPECT_EQ(file.waypoints[0].joints[hand::shadow_hand().joint("WRJ2")], 2);
}

TEST(Waypoints, MountIsReadOrGiven) {
  const std::string joints = row(0);
  const auto wide = parse_waypoints(
      "x,y,z,yaw,pitch,roll," + header() + "\n1,2,3,4,5,6," + joints + "\n1,2,3,4,5,6," + joints,
      "q.csv", {}, hand::shadow_hand());
  EXPECT_TRUE(wide.has_mount);
  EXPECT_EQ(wide.waypoints[0].mount.xyz, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(wide.waypoints[1].mount.ypr, Eigen::Vector3d(4, 5, 6));
  hand::MountPosition mount;
  mount.xyz.z() = 0.4;
  const auto narrow = parse_waypoints(header() + "\n" + joints + "\n" + joints, "q.csv", mount,
                                      hand::shadow_hand());
  EXPECT_EQ(narrow.waypoints[1].mount.xyz.z(), 0.4);
}

TEST(Waypoints, TheTimesOfAPlannedPathAreLeftOut) {
  const std::string text = "t_s," + header() + "\n0.00," + row(1) + "\n0.01," + row(2);
  const auto file = parse_waypoints(text, "path.csv", {}, hand::shadow_hand());
  ASSERT_EQ(file.waypoints.size(), 2U);
  EXPECT_EQ(file.waypoints[0].joints[0], 1);
  EXPECT_EQ(file.waypoints[1].joints[0], 2);
  const std::string untimed = "t_s," + header() + "\n" + row(1) + "\n" + row(2);
  EXPECT_THROW((void)parse_waypoints(untimed, "path.csv", {}, hand::shadow_hand()), BadInput);
}

TEST(Waypoints, BadFilesAreNamed) {
  const auto message = [](const std::string& text) {
    return error_message([&] { (void)parse_waypoints(text, "q.csv", {}, hand::shadow_hand()); });
  };
  const std::string good = row(0);
  EXPECT_NE(message("").find("q.csv is empty"), std::string::npos);
  EXPECT_NE(message(header() + "\n" + good).find("not 1"), std::string::npos);
  EXPECT_NE(message("WRJ2,WRJ1\n0,0\n").find("q.csv:1: 2 columns"), std::string::npos);
  EXPECT_NE(message(header() + "\n" + row(0, 23) + "\n").find("q.csv:2: 23 values for 24"),
            std::string::npos);
  std::string nan = good;
  nan.replace(0, 1, "nan");
  EXPECT_NE(message(header() + "\n" + good + "\n" + nan).find("q.csv:3: 'nan' in column WRJ2"),
            std::string::npos);
  std::string twice = header();
  twice.replace(twice.find("WRJ2"), 4, "WRJ1");
  EXPECT_NE(message(twice + "\n" + good).find("WRJ1 comes twice"), std::string::npos);
  std::string unknown = header();
  unknown.replace(unknown.find("FFJ3"), 4, "FFJ9");
  EXPECT_NE(message(unknown + "\n" + good).find("'FFJ9'"), std::string::npos);
}

TEST(Faults, NameTheWaypointTheJointAndTheValue) {
  simulation::CollisionScene scene(drawn_hand());
  std::vector<Waypoint> waypoints(5, open_hand(0, 0, 0.3));
  EXPECT_TRUE(find_invalid_waypoints(waypoints, scene).empty());
  joint(waypoints[1], "FFJ3") = 2.5;
  joint(waypoints[2], "THJ4") = std::numeric_limits<double>::quiet_NaN();
  joint(waypoints[3], "MFJ1") = 0.5, joint(waypoints[3], "MFJ2") = 0.2;
  waypoints[4].mount.xyz.x() = 3;
  const auto faults = find_invalid_waypoints(waypoints, scene);
  ASSERT_EQ(faults.size(), 4U);
  const std::vector<std::pair<std::string, std::string>> words = {{"FFJ3 = 2.5 rad", "1.571"},
                                                                  {"THJ4", "nan"},
                                                                  {"MFJ1 = 0.5 rad", "MFJ2 = 0.2"},
                                                                  {"x = 3 m", "1"}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(faults[i].waypoint, i + 1);
    EXPECT_NE(faults[i].reason.find(words[i].first), std::string::npos) << faults[i].reason;
    EXPECT_NE(faults[i].reason.find(words[i].second), std::string::npos) << faults[i].reason;
  }
}

TEST(Faults, NameThePairOfBodies) {
  simulation::CollisionScene scene(plate(), drawn_hand());
  scene.place(at(0, 0, 0.08));
  std::vector<Waypoint> waypoints = {open_hand(0, 0, 0.3), open_hand(0, 0, 0.1),
                                     open_hand(0, 0.5, 0.0), open_hand(0, 0, 0.4)};
  joint(waypoints[3], "FFJ4") = 0.349;  // towards the middle finger
  const auto faults = find_invalid_waypoints(waypoints, scene);
  ASSERT_EQ(faults.size(), 3U);
  EXPECT_EQ(faults[0].waypoint, 1U);
  EXPECT_NE(faults[0].reason.find("object"), std::string::npos) << faults[0].reason;
  EXPECT_EQ(faults[1].waypoint, 2U);
  EXPECT_NE(faults[1].reason.find("table"), std::string::npos) << faults[1].reason;
  EXPECT_EQ(faults[2].waypoint, 3U);
  EXPECT_NE(faults[2].reason.find("ff"), std::string::npos) << faults[2].reason;
  EXPECT_NE(faults[2].reason.find("mf"), std::string::npos) << faults[2].reason;
}

}  // namespace
}  // namespace palpate::planning
