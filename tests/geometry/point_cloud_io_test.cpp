// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/io/point_cloud_io.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/temporary_folder.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/mesh/mesh.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

class CloudFiles : public ::testing::Test {
 protected:
  PointCloud load(const std::string& name, std::string_view content) {
    const auto path = folder_.path() / name;
    std::ofstream(path, std::ios::binary) << content;
    return load_cloud(path);
  }

  TemporaryFolder folder_;
};

std::string from_hex(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  }
  return bytes;
}

std::string pcd_header(const std::string& data, int points = 16) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n"
         "TYPE F F F\nCOUNT 1 1 1\nWIDTH 16\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
         std::to_string(points) + "\nDATA " + data + "\n";
}

TEST_F(CloudFiles, PlyComesBackExactly) {
  RandomStream random(1, "cloud");
  PointCloud cloud;
  for (int i = 0; i < 50; ++i) {
    cloud.points.push_back(random.normal3());
    cloud.normals.push_back(random.unit_vector());
  }
  for (const bool normals : {true, false}) {
    if (!normals) cloud.normals.clear();
    save_cloud(folder_.path() / "c.ply", cloud);
    const PointCloud again = load_cloud(folder_.path() / "c.ply");
    EXPECT_EQ(again.points, cloud.points);
    ASSERT_EQ(again.normals.size(), cloud.normals.size());
    for (std::size_t i = 0; i < cloud.normals.size(); ++i) {
      EXPECT_LT((again.normals[i] - cloud.normals[i]).norm(), 1e-15);
    }
  }
}

TEST_F(CloudFiles, Xyz) {
  const PointCloud cloud = load("a.xyz", "# x y z nx ny nz\n1 2 3 0 0 1.01\n\n4,5,6,1,0, 0 #\n");
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.points[1], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(cloud.normals[0], Eigen::Vector3d(0, 0, 1));
  EXPECT_FALSE(load("b.xyz", "1 2 3 0 0 1\n4 5 6\n").has_normals());
  EXPECT_EQ(load("c.xyz", "\n# nothing\n").size(), 0u);
  EXPECT_THROW(load("d.xyz", "1 2\n"), BadInput);
  EXPECT_THROW(load("e.xyz", "1 2 nan\n"), BadInput);
  EXPECT_THROW(load("f.xyz", "1 2 three\n"), BadInput);
}

TEST_F(CloudFiles, ColoursOfAnXyzAreNoNormals) {
  const PointCloud cloud = load("a.xyz", "1 2 3 255 128 0\n4 5 6 1 0 0\n");
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_FALSE(cloud.has_normals());
}

TEST_F(CloudFiles, DecimalCommasOfAnXyzAreRefused) {
  try {
    load("a.xyz", "0 0 0\n1,5 2,3 3,1\n");
    FAIL() << "they were taken for six numbers";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("a.xyz: line 2: blanks and commas"), std::string::npos)
        << error.what();
  }
}

TEST_F(CloudFiles, AByteOrderMarkIsPassedOver) {
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(load("a.xyz", mark + "1 2 3\n4 5 6\n").size(), 2u);
  EXPECT_EQ(load("a.obj", mark + "v 1 2 3\nv 4 5 6\n").size(), 2u);
}

// Bytes as Open3D 0.20 writes a grid of 4 x 4 points at z = 0.5.
TEST_F(CloudFiles, CompressedPcdOfAnotherProgram) {
  const std::string data = from_hex(
      "31000000c0000000010000400001803f20050040200220034000e0270fe00300403be003034057e003034063"
      "e003030000407be02e0301003f");
  const PointCloud cloud = load("c.pcd", pcd_header("binary_compressed") + data);
  ASSERT_EQ(cloud.size(), 16u);
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(cloud.points[static_cast<std::size_t>(i)], Eigen::Vector3d(i % 4, i / 4, 0.5));
  }
  for (std::size_t size = 0; size < data.size(); ++size) {
    EXPECT_THROW(load("c.pcd", pcd_header("binary_compressed") + data.substr(0, size)), BadInput);
  }
}

TEST_F(CloudFiles, PcdWhoseCountsAreNoneOrWrapIsRefused) {
  const std::string three = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  const std::vector<std::string> headers = {
      three + "COUNT 0 0 0\nPOINTS 4611686018427387904\nDATA ascii\n",
      three + "COUNT 0 0 0\nPOINTS 1\nDATA binary\nQ",
      "FIELDS x y z a\nSIZE 4 4 4 0\nTYPE F F F U\nPOINTS 1\nDATA binary\n0123456789abcdef",
      "FIELDS x y z a b\nSIZE 4 4 4 1 1\nTYPE F F F U U\nCOUNT 1 1 1 9223372036854775807 "
      "9223372036854775798\nPOINTS 5\nDATA binary\nABCDE",
      three + "POINTS 9223372036854775807\nDATA ascii\n1 2 3\n",
      three + "POINTS 1537228672809129302\nDATA binary\n0123456789abcdef",
      three + "POINTS 357913942\nDATA binary_compressed\n\x01\0\0\0\x08\0\0\0Q"};
  for (const auto& header : headers) EXPECT_THROW(load("w.pcd", header), BadInput) << header;
}

TEST_F(CloudFiles, CoordinatesThatNothingCanBeComputedWithAreRefused) {
  EXPECT_THROW(load("far.xyz", "1 2 1e200\n"), BadInput);
  EXPECT_EQ(load("far.xyz", "1 2 1e9\n").size(), 1u);
}

TEST_F(CloudFiles, AsciiAndBinaryPcd) {
  const PointCloud ascii =
      load("a.pcd",
           "VERSION .7\nFIELDS x y z normal_x normal_y normal_z rgb\nSIZE 4 4 4 4 4 4 4\n"
           "TYPE F F F F F F U\nCOUNT 1 1 1 1 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n"
           "1 2 3 0 0 1 255\nnan nan nan 0 0 1 0\n4 5 6 1 0 0 7\n");
  ASSERT_EQ(ascii.size(), 2u);  // a ray that hit nothing is no point
  EXPECT_EQ(ascii.points[1], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(ascii.normals[1], Eigen::Vector3d(1, 0, 0));
  const float values[6] = {1, 2, 3, 4, 5, 6};
  const std::string bytes(reinterpret_cast<const char*>(values), sizeof(values));
  EXPECT_EQ(load("b.pcd", pcd_header("binary", 2) + bytes).points[1], Eigen::Vector3d(4, 5, 6));
  EXPECT_THROW(load("c.pcd", pcd_header("binary", 3) + bytes), BadInput);
  EXPECT_THROW(load("d.pcd", pcd_header("binary", 2000000000) + bytes), BadInput);
  EXPECT_THROW(load("e.pcd", pcd_header("zip", 2) + bytes), BadInput);
  EXPECT_THROW(load("f.pcd", "VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 1\nDATA ascii\n"),
               BadInput);
}

TEST_F(CloudFiles, MeshesAreSampled) {
  const TriangleMesh box = box_mesh({0.1, 0.2, 0.3});
  save_ply(folder_.path() / "box.ply", box);
  const PointCloud cloud = load_cloud(folder_.path() / "box.ply", 500);
  ASSERT_EQ(cloud.size(), 500u);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Array3d beyond = cloud.points[i].array().abs() - Eigen::Array3d(0.05, 0.1, 0.15);
    EXPECT_NEAR(beyond.maxCoeff(), 0, 1e-12);
    EXPECT_GT(cloud.points[i].dot(cloud.normals[i]), 0);
  }
  const PointCloud vertices = load("v.obj", "v 1 2 3\nv 4 5 6\n");
  EXPECT_EQ(vertices.points[1], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(load("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").size(), 20000u);
}

TEST_F(CloudFiles, BadFiles) {
  EXPECT_THROW(load("a.abc", "1 2 3\n"), BadInput);
  EXPECT_THROW(load("a.xyz", ""), BadInput);
  EXPECT_THROW(load("a.ply", "1 2 3\n"), BadInput);
  EXPECT_THROW(load_cloud(folder_.path() / "none.ply"), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
