// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/contacts_io.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::localization {
namespace {

TEST(ParseContacts, ReadsColumnsInAnyOrder) {
  const auto contacts =
      parse_contacts(",nz,ny,nx,x,y,z,finger,t,fx,fy,fz\r\n7,1,0,0,0.1,0.2,0.3,MF,1.5,0,0,-1\r\n",
                     "c.csv", {0.002, 0.1});
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_TRUE(contacts[0].p.isApprox(Eigen::Vector3d(0.1, 0.2, 0.3)));
  EXPECT_TRUE(contacts[0].n.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(contacts[0].f.isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_EQ(contacts[0].finger, 2);
  EXPECT_EQ(contacts[0].time, 1.5);
  EXPECT_EQ(contacts[0].point_sigma, 0.002);
  EXPECT_EQ(contacts[0].normal_sigma, 0.1);
}

TEST(ParseContacts, FingersOfOtherHandsAreNotNumbered) {
  const auto contacts = parse_contacts("x,y,z,finger\n1,0,0,3\n1,0,0,2nd\n1,0,0,thumb\n", "c");
  ASSERT_EQ(contacts.size(), 3U);
  EXPECT_EQ(contacts[0].finger, 3);
  EXPECT_EQ(contacts[1].finger, -1);
  EXPECT_EQ(contacts[2].finger, -1);
}

TEST(ParseContacts, SortsByTime) {
  const auto contacts = parse_contacts("x,y,z,nx,ny,nz,t\n1,0,0,0,0,1,2\n2,0,0,0,0,1,1\n", "c");
  ASSERT_EQ(contacts.size(), 2U);
  EXPECT_EQ(contacts[0].p.x(), 2);
}

TEST(ParseContacts, NormalsAndOwnErrorsAreOptional) {
  const auto bare = parse_contacts("x,y,z\n1,0,0\n", "c", {0.002, 0.1});
  ASSERT_EQ(bare.size(), 1U);
  EXPECT_FALSE(bare[0].has_normal());
  EXPECT_EQ(bare[0].group, -1);
  const auto parsed = parse_contacts(
      "x,y,z,nx,ny,nz,point_sigma,normal_sigma,group\n"
      "1,0,0,0,0.995,0,0.003,0.2,\n1,0,0,,,,,,4\n",
      "c", {0.002, 0.1});
  ASSERT_EQ(parsed.size(), 2U);
  EXPECT_TRUE(parsed[0].n.isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_EQ(parsed[0].point_sigma, 0.003);
  EXPECT_EQ(parsed[0].normal_sigma, 0.2);
  EXPECT_EQ(parsed[0].group, -1);
  EXPECT_FALSE(parsed[1].has_normal());
  EXPECT_EQ(parsed[1].point_sigma, 0.002);
  EXPECT_EQ(parsed[1].group, 4);
}

TEST(ParseContacts, MayHoldNone) { EXPECT_TRUE(parse_contacts("x,y,z,nx,ny,nz\n\n", "c").empty()); }

std::string refusal(const std::string& text) {
  try {
    parse_contacts(text, "c.csv");
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(ParseContacts, NamesWhatIsWrong) {
  const std::string header = "x,y,z,nx,ny,nz\n";
  EXPECT_NE(refusal("").find("empty"), std::string::npos);
  EXPECT_NE(refusal("x,y,z,nx,ny\n").find("nz"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,0,0,0\n").find("c.csv:2"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,nan,0,0,1\n").find("'nan' in column z"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,1e999,0,0,1\n").find("1e999"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,0,0,0,0\n").find("length 0"), std::string::npos);
  EXPECT_NE(refusal("x,y,z,point_sigma\n0,0,0,-0.5\n").find("point_sigma is -0.5"),
            std::string::npos);
  EXPECT_NE(refusal("x,y,z,group\n0,0,0,1.5\n").find("group is '1.5'"), std::string::npos);
  const std::string far = refusal(header + "0,0,1e200,0,0,1\n");
  EXPECT_NE(far.find("c.csv:2: a coordinate in m"), std::string::npos) << far;
  EXPECT_NE(far.find("of 1e+200"), std::string::npos) << far;
  EXPECT_NE(refusal("x,y,z,nx,ny,nz,fx,fy,fz\n0,0,0,0,0,1,0,0,-1e200\n").find("a force of -1e+200"),
            std::string::npos);
}

TEST(ParseContacts, RefusesColumnsThatItDoesNotKnow) {
  const std::string misspelt = refusal("x,y,z,point_sigm\n0,0,0,0.001\n");
  EXPECT_NE(misspelt.find("c.csv:1: unknown column 'point_sigm' (known: x, y, z, nx"),
            std::string::npos)
      << misspelt;
  EXPECT_NE(misspelt.find("; did you mean 'point_sigma'?"), std::string::npos) << misspelt;
  const std::string foreign = refusal("x,y,z,temperature\n0,0,0,20\n");
  EXPECT_NE(foreign.find("'temperature'"), std::string::npos) << foreign;
  EXPECT_EQ(foreign.find("did you mean"), std::string::npos) << foreign;
}

TEST(ParseContacts, NamesTheLineOfEachContact) {
  const std::string text = "x,y,z,t\n1,0,0,3\n\n2,0,0,1\n3,0,0,2\n";
  const auto contacts = parse_contacts(text, "c.csv");
  const auto lines = contact_lines(text, "c.csv");
  EXPECT_EQ(lines, (std::vector<std::size_t>{4, 5, 2}));
  ASSERT_EQ(contacts.size(), 3U);
  EXPECT_EQ(contacts[0].p.x(), 2);
  EXPECT_EQ(contacts[2].p.x(), 1);
}

TEST(ParseContacts, ReadsWhatTheProgramWritesOfAFinger) {
  EXPECT_EQ(refusal("t,x,y,z,fx,fy,fz,nx,ny,nz,sigma_deg,error_deg,flags\n"
                    "0,0,0,0,0,0,-1,0,0,1,3,2,edge\n"),
            "");
}

TEST(ParseContacts, RefusesNormalsThatAreNotUnit) {
  const std::string header = "x,y,z,nx,ny,nz\n";
  EXPECT_EQ(refusal(header + "0,0,0,0.58,0.58,0.58\n"), "");  // rounded
  for (const auto& [cells, length] : {std::pair{"0,0,2", "2"}, {"0,0.985,0", "0.985"}}) {
    EXPECT_NE(refusal(header + "0,0,0,0,0,1\n0,0,0," + cells + "\n")
                  .find(std::string("c.csv:3: a normal of length ") + length + ", not 1"),
              std::string::npos)
        << cells;
  }
}

/// Reads a text as a file of planes.
std::vector<PlaneContact> planes(const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / "palpate_plane_contacts_test.csv";
  std::ofstream(path) << text;
  const auto read = read_plane_contacts(path);
  std::filesystem::remove(path);
  return read;
}

std::string refusal_of_planes(const std::string& text) {
  try {
    planes(text);
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

/// As millimetres and degrees are.
TEST(ParseContacts, SigmasThatNoModelOfContactsRepresentsAreRefused) {
  for (const std::string row : {"point_sigma\n0,0,0,1\n", "normal_sigma\n0,0,0,10\n"}) {
    EXPECT_THROW((void)parse_contacts("x,y,z," + row, "contacts.csv"), BadInput) << row;
  }
}

TEST(ReadPlaneContacts, ReadsPlanes) {
  const auto read = planes("height,sigma,nx,ny,nz\n0.1,,0,0,1\n-0.2,0.003,1,0,0\n");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_TRUE(read[0].normal.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_EQ(read[0].height, 0.1);
  EXPECT_EQ(read[0].sigma, PlaneContact{}.sigma);
  EXPECT_EQ(read[1].height, -0.2);
  EXPECT_EQ(read[1].sigma, 0.003);
}

TEST(ReadPlaneContacts, NamesWhatIsWrong) {
  const std::string header = "nx,ny,nz,height,sigma\n";
  EXPECT_NE(refusal_of_planes("nx,ny,nz\n0,0,1\n").find("height"), std::string::npos);
  EXPECT_NE(refusal_of_planes(header + "0,0,0,0,\n").find(":2: a normal of length 0"),
            std::string::npos);
  EXPECT_NE(refusal_of_planes(header + "0,0,2,0.1,\n").find(":2: a normal of length 2, not 1"),
            std::string::npos);
  EXPECT_NE(refusal_of_planes("nx,ny,nz,height,sigm\n0,0,1,0.1,0.01\n")
                .find("unknown column 'sigm' (known: nx, ny, nz, height, sigma); did you mean "
                      "'sigma'?"),
            std::string::npos);
  EXPECT_NE(refusal_of_planes(header + "0,0,1,1e20,\n").find(":2: a height in m of 1e+20"),
            std::string::npos);
  EXPECT_NE(refusal_of_planes(header + "0,0,1,0,0\n").find("sigma is 0"), std::string::npos);
}

}  // namespace
}  // namespace palpate::localization
