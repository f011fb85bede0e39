// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/correspondences_io.hpp"

#include <gtest/gtest.h>

#include <string>

#include "palpate/core/error.hpp"

namespace palpate::registration {
namespace {

std::string error_of(std::string_view text) {
  try {
    parse_correspondences(text, "pairs.csv");
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(ParseCorrespondences, ColumnsInAnyOrderWithOthers) {
  const auto c = parse_correspondences(
      "name,tx,ty,tz,sx,sy,sz\r\n0,1,2,3,4,5,6\r\n\r\n 1 , 1e-3,-2,3,4,5,6", "pairs.csv");
  ASSERT_EQ(c.size(), 2u);
  EXPECT_EQ(c.source[0], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(c.target[1], Eigen::Vector3d(1e-3, -2, 3));
  EXPECT_FALSE(c.has_normals());
}

TEST(ParseCorrespondences, OtherColumnsMayHoldAnything) {
  const auto c =
      parse_correspondences("sx,sy,sz,tx,ty,tz,name,residual\n1,2,3,4,5,6,ear,nan\n", "pairs.csv");
  ASSERT_EQ(c.size(), 1u);
  EXPECT_EQ(c.target[0], Eigen::Vector3d(4, 5, 6));
}

TEST(ParseCorrespondences, NormalsBecomeUnitVectors) {
  const auto c = parse_correspondences(
      "sx,sy,sz,tx,ty,tz,snx,sny,snz,tnx,tny,tnz\n0,0,0,1,1,1,0,0,2,3,4,0\n", "pairs.csv");
  ASSERT_TRUE(c.has_normals());
  EXPECT_EQ(c.source_normals[0], Eigen::Vector3d(0, 0, 1));
  EXPECT_TRUE(c.target_normals[0].isApprox(Eigen::Vector3d(0.6, 0.8, 0)));
}

TEST(ParseCorrespondences, ErrorsNameTheLineAndTheValue) {
  EXPECT_EQ(error_of("sx,sy,sz,tx,ty\n"), "pairs.csv:1: no columns tx, ty, tz in the header");
  const std::string header = "sx,sy,sz,tx,ty,tz\n";
  EXPECT_EQ(error_of(header + "1,2,3,4,5,6\n1,2,3\n"), "pairs.csv:3: 3 values for 6 columns");
  EXPECT_EQ(error_of(header + "1,2,x,4,5,6\n"),
            "pairs.csv:2: 'x' in column sz is not a finite number");
  EXPECT_EQ(error_of(header + "1,2,nan,4,5,6\n"),
            "pairs.csv:2: 'nan' in column sz is not a finite number");
  EXPECT_NE(error_of(header + "1,2,inf,4,5,6\n"), "");
  EXPECT_NE(error_of(""), "");
  EXPECT_EQ(error_of("sx,sy,sz,tx,ty,tz,snx,sny,snz\n1,2,3,4,5,6,0,0,0\n"),
            "pairs.csv:2: a normal of length 0");
}

TEST(ParseCorrespondences, HeaderAloneIsNoPairs) {
  EXPECT_EQ(parse_correspondences("sx,sy,sz,tx,ty,tz\n", "pairs.csv").size(), 0u);
}

}  // namespace
}  // namespace palpate::registration
