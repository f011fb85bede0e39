// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/free_space.hpp"

#include <gtest/gtest.h>

#include <string>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::localization {
namespace {

/// A file that is there while the test runs.
class ReadFreeSpace : public testing::Test {
 protected:
  std::vector<FreeSphere> read(const std::string& text) {
    write_file_atomically(path_, text);
    return read_free_space(path_);
  }
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const BadInput& error) {
      return error.what();
    }
    return "";
  }
  ~ReadFreeSpace() override { std::filesystem::remove(path_); }

 private:
  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                (std::string("palpate_free_space_") +
                                 testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(ReadFreeSpace, ReadsBalls) {
  const auto spheres = read("radius,x,y,z\n0.01,1,2,3\n");
  ASSERT_EQ(spheres.size(), 1U);
  EXPECT_TRUE(spheres[0].center.isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_EQ(spheres[0].radius, 0.01);
  EXPECT_TRUE(read("x,y,z,radius\n").empty());
  EXPECT_TRUE(read("x,y,z,size\n").empty());
}

/// Eight voxels that make a cube, in any order, and one beside it.
TEST_F(ReadFreeSpace, JoinsVoxels) {
  std::string text = "x,y,z,size\n1.05,0.03,0.01,0.02\n";
  for (int i = 7; i >= 0; --i) {
    text += std::to_string(1.01 + 0.02 * (i & 1)) + "," +
            std::to_string(0.01 + 0.02 * (i >> 1 & 1)) + "," +
            std::to_string(0.01 + 0.02 * (i >> 2)) + ",0.02\n";
  }
  const auto spheres = read(text);
  ASSERT_EQ(spheres.size(), 2U);
  EXPECT_TRUE(spheres[0].center.isApprox(Eigen::Vector3d(1.05, 0.03, 0.01), 1e-9));
  EXPECT_NEAR(spheres[0].radius, 0.01, 1e-12);
  EXPECT_TRUE(spheres[1].center.isApprox(Eigen::Vector3d(1.02, 0.02, 0.02), 1e-9));
  EXPECT_NEAR(spheres[1].radius, 0.02, 1e-12);
}

TEST_F(ReadFreeSpace, NamesWhatIsWrong) {
  EXPECT_NE(refusal("x,y,z\n0,0,0\n").find("radius"), std::string::npos);
  EXPECT_NE(refusal("radius,x,y,z\n-1,0,0,0\n").find("radius"), std::string::npos);
  EXPECT_NE(refusal("x,y,z,size\n0,0,0,0.01\n0.014,0,0,0.01\n").find("voxel 1"), std::string::npos);
  EXPECT_NE(refusal("x,y,z,size\n0,0,0,0.01\n0.01,0,0,0.02\n").find("voxel 1"), std::string::npos);
  EXPECT_NE(refusal("x,y,z,size\n0,0,0,0\n").find("0 m"), std::string::npos);
  EXPECT_NE(refusal("x,y,z,size\n0,0,0,1e-6\n1,1,1,1e-6\n").find("grid"), std::string::npos);
}

TEST(FreeSpheresOf, ChecksTheGrid) {
  FreeVoxels voxels{{2, 1, 1}, {1, 0}, 0.01};
  ASSERT_EQ(free_spheres_of(voxels).size(), 1U);
  EXPECT_TRUE(free_spheres_of(voxels)[0].center.isApprox(Eigen::Vector3d(0.005, 0.005, 0.005)));
  voxels.size.x() = 3;
  EXPECT_THROW(free_spheres_of(voxels), BadInput);
  voxels = {{1, 1, 1}, {1}, 0};
  EXPECT_THROW(free_spheres_of(voxels), BadInput);
}

/// Odd sizes, and a ball of every size.
TEST(FreeSpheresOf, AllFree) {
  const FreeVoxels voxels{{5, 4, 4}, std::vector<char>(80, 1), 0.01};
  const auto spheres = free_spheres_of(voxels);
  ASSERT_EQ(spheres.size(), 17U);  // one of 4 x 4 x 4, and 16 beside it
  EXPECT_NEAR(spheres.back().radius, 0.02, 1e-12);
  EXPECT_TRUE(spheres.back().center.isApprox(Eigen::Vector3d(0.02, 0.02, 0.02)));
}

}  // namespace
}  // namespace palpate::localization
