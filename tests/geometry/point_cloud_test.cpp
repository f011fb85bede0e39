// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/point_cloud.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "geometry/test_meshes.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/cloud/fpfh.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "palpate/geometry/cloud/outlier_filter.hpp"
#include "palpate/geometry/mesh/sampling.hpp"

namespace palpate::geometry {
namespace {

using testing::torus_mesh;

PointCloud torus_cloud(std::size_t count) {
  PointCloud cloud;
  for (const auto& s :
       sample_surface(torus_mesh(0.05, 0.02, 60, 30), count, RandomStream(1, "torus"))) {
    cloud.points.push_back(s.point);
    cloud.normals.push_back(s.normal);
  }
  return cloud;
}

TEST(KdTree, FindsWhatExhaustiveSearchFinds) {
  const PointCloud cloud = torus_cloud(400);
  const KdTree tree(cloud.points);
  RandomStream random(2, "queries");
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d q = 0.05 * random.normal3();
    std::vector<std::pair<double, int>> all;
    for (int i = 0; i < 400; ++i) {
      all.emplace_back((cloud.points[static_cast<std::size_t>(i)] - q).squaredNorm(), i);
    }
    std::ranges::sort(all);
    for (const std::size_t count : {7u, 300u, 400u}) {
      const auto nearest = tree.nearest(q, static_cast<int>(count));
      ASSERT_EQ(nearest.size(), count);
      for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(nearest[i].index, all[i].second);
    }
    const double radius = std::sqrt(all[20].first) * (1 + 1e-9);
    const auto within = tree.within(q, radius);
    ASSERT_EQ(within.size(), 21u);
    for (std::size_t i = 0; i < 21; ++i) EXPECT_EQ(within[i].index, all[i].second);
  }
}

TEST(KdTree, EdgeCases) {
  EXPECT_TRUE(KdTree({}).nearest({0, 0, 0}, 3).empty());
  EXPECT_TRUE(KdTree({}).within({0, 0, 0}, 1).empty());
  EXPECT_EQ(KdTree({{1, 2, 3}}).nearest({0, 0, 0}, 3).size(), 1u);
  EXPECT_EQ(KdTree(std::vector<Eigen::Vector3d>(30, {1, 2, 3})).within({1, 2, 3}, 1).size(), 30u);
  EXPECT_THROW(KdTree({{1, 2, std::nan("")}}), BadInput);
}

TEST(VoxelSampling, KeepsOnePointACell) {
  const PointCloud cloud = torus_cloud(3000);
  const double cell = voxel_cell_for(cloud, 500);
  const PointCloud sampled = voxel_sampled(cloud, cell);
  EXPECT_LE(sampled.size(), 500u);
  EXPECT_GT(sampled.size(), 350u);
  const KdTree tree(cloud.points);
  for (std::size_t i = 0; i < sampled.size(); ++i) {
    EXPECT_NEAR(sampled.normals[i].norm(), 1, 1e-12);
    EXPECT_LT(tree.nearest(sampled.points[i], 1)[0].squared_distance, 3 * cell * cell);
  }
  EXPECT_EQ(voxel_cell_for(cloud, 3000), 0);
  EXPECT_EQ(voxel_sampled(cloud, 10).size(), 1u);
  EXPECT_THROW(voxel_sampled(cloud, 0), BadInput);
  EXPECT_TRUE(voxel_sampled(PointCloud{}, 1).points.empty());
}

TEST(PointView, ReadsPointsWhereTheyAre) {
  struct Row {
    float intensity, x, y, z, nx, ny, nz;
  };
  const PointCloud cloud = torus_cloud(200);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.points[i].cast<float>(), n = cloud.normals[i].cast<float>();
    rows.push_back({1, p.x(), p.y(), p.z(), n.x(), n.y(), n.z()});
  }
  const PointView view =
      PointView(&rows[0].x, rows.size(), sizeof(Row)).with_normals(&rows[0].nx, sizeof(Row));
  const PointCloud copy = copied(view), sampled = voxel_sampled(view, 0.02),
                   expected = voxel_sampled(copy, 0.02);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LT((copy.points[i] - cloud.points[i]).norm(), 1e-6);
    EXPECT_LT((copy.normals[i] - cloud.normals[i]).norm(), 1e-6);
  }
  EXPECT_EQ(sampled.points, expected.points);
  EXPECT_EQ(sampled.normals, expected.normals);
  rows[7].y = std::nanf("");
  EXPECT_THROW(check_cloud(view), BadInput);
  EXPECT_THROW(check_cloud(PointCloud{cloud.points, {cloud.normals[0]}}), BadInput);
}

TEST(OutlierFilter, DropsPointsFarFromTheRest) {
  PointCloud cloud = torus_cloud(1500);
  RandomStream random(3, "outliers");
  for (int i = 0; i < 30; ++i) cloud.points.push_back(1.0 * random.unit_vector());
  cloud.normals.clear();
  const auto kept = statistical_inliers(cloud, {.neighbours = 20, .deviation_ratio = 0.5});
  EXPECT_GT(kept.size(), 1400u);
  for (const int i : kept) EXPECT_LT(i, 1500);
  // The thesis' setting, of more neighbours than a small cloud has.
  EXPECT_FALSE(statistical_inliers(torus_cloud(100)).empty());
}

TEST(OutlierFilter, EdgeCases) {
  EXPECT_TRUE(statistical_inliers({}).empty());
  EXPECT_EQ(statistical_inliers({{{1, 2, 3}}, {}}).size(), 1u);
  const PointCloud same{std::vector<Eigen::Vector3d>(20, {1, 2, 3}), {}};
  EXPECT_EQ(statistical_inliers(same).size(), 20u);
  EXPECT_THROW(statistical_inliers(same, {.neighbours = 0}), BadInput);
  EXPECT_THROW(statistical_inliers(same, {.deviation_ratio = 0}), BadInput);
  EXPECT_THROW(statistical_inliers({{{1, 2, std::nan("")}}, {}}), BadInput);
}

TEST(Normals, PointOutOfAClosedSurface) {
  const PointCloud truth = torus_cloud(3000), found = with_normals({truth.points, {}});
  std::vector<double> cosines;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    cosines.push_back(found.normals[i].dot(truth.normals[i]));
  }
  std::ranges::sort(cosines);
  EXPECT_GT(cosines[30], 0.8);     // all but 1 %
  EXPECT_GT(cosines[1500], 0.97);  // half
}

TEST(Normals, BadInput) {
  EXPECT_THROW(with_normals({{{0, 0, 0}, {1, 0, 0}}, {}}), BadInput);
  EXPECT_THROW(with_normals({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, {}}), BadInput);
  EXPECT_THROW(with_normals({std::vector<Eigen::Vector3d>(9, {1, 2, 3}), {}}), BadInput);
}

PointCloud wavy_sheet() {
  PointCloud cloud;
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      const double x = 0.01 * (i + 0.3 * std::sin(5.0 * j));
      const double y = 0.01 * (j + 0.3 * std::cos(3.0 * i));
      cloud.points.emplace_back(x, y, 0.02 * std::sin(40 * x) * std::cos(25 * y));
      cloud.normals.push_back(Eigen::Vector3d(-0.8 * std::cos(40 * x) * std::cos(25 * y),
                                              0.5 * std::sin(40 * x) * std::sin(25 * y), 1)
                                  .normalized());
    }
  }
  return cloud;
}

// Golden values: Open3D 0.20, compute_fpfh_feature, hybrid search of 0.03 m and 101 points.
TEST(Fpfh, EqualsAnIndependentImplementation) {
  const Features features = fpfh(wavy_sheet(), 0.03, 100);
  ASSERT_EQ(features.cols(), 144);
  const auto expect_column = [&](int column, const std::vector<float>& golden) {
    for (int bin = 0; bin < kFpfhBins; ++bin) {
      EXPECT_NEAR(features(bin, column), golden[static_cast<std::size_t>(bin)], 0.001)
          << column << " " << bin;
    }
  };
  expect_column(0, {0, 0, 0, 0,       0,        179.7321F, 20.2679F, 0,       0, 0, 0,
                    0, 0, 0, 0,       10.0431F, 173.9309F, 15.8622F, 0.1638F, 0, 0, 0,
                    0, 0, 0, 1.0947F, 79.7971F, 118.8096F, 0.2986F,  0,       0, 0, 0});
  expect_column(65, {0, 0, 0, 0,       7.5160F,  157.7941F, 34.6899F, 0,       0, 0, 0,
                     0, 0, 0, 2.3019F, 40.1963F, 113.9657F, 40.5348F, 3.0013F, 0, 0, 0,
                     0, 0, 0, 0.4987F, 77.3568F, 100.9489F, 21.1956F, 0,       0, 0, 0});
  expect_column(100, {0, 0, 0, 0,        24.8975F, 156.5358F, 18.5667F, 0,        0, 0, 0,
                      0, 0, 0, 19.3043F, 47.8790F, 57.5106F,  64.5799F, 10.7262F, 0, 0, 0,
                      0, 0, 0, 0,        42.1361F, 96.1685F,  61.5930F, 0.1025F,  0, 0, 0});
  expect_column(143, {0, 0, 0, 0,       0.4711F,  165.1212F, 34.4077F, 0,       0, 0, 0,
                      0, 0, 0, 0.1757F, 33.0326F, 120.1418F, 46.4742F, 0.1757F, 0, 0, 0,
                      0, 0, 0, 0,       90.5712F, 106.0892F, 3.3396F,  0,       0, 0, 0});
}

TEST(Fpfh, DoesNotDependOnThePose) {
  RandomStream random(4, "pose");
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  T.translation() = random.normal3();
  const PointCloud cloud = torus_cloud(300);
  const Features a = fpfh(cloud, 0.02), b = fpfh(transformed(T, cloud), 0.02);
  // A value on the edge between two bins may fall to either side.
  EXPECT_LT((a - b).colwise().norm().mean(), 0.5F);
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    const float sum = a.col(i).sum();
    EXPECT_TRUE(sum == 0 || std::abs(sum - 600) < 0.01F);
  }
}

TEST(Fpfh, OfTurnedNormalsAndMirrorImages) {
  const PointCloud cloud = torus_cloud(300);
  PointCloud inward = cloud, image = cloud;
  for (auto& n : inward.normals) n = -n;
  for (auto* list : {&image.points, &image.normals}) {
    for (auto& p : *list) p.x() = -p.x();
  }
  const Features features = fpfh(cloud, 0.02);
  // A value on the edge between two bins may fall to either side.
  EXPECT_LT((turned_inside_out(features) - fpfh(inward, 0.02)).colwise().norm().mean(), 0.5F);
  EXPECT_LT((mirrored(features) - fpfh(image, 0.02)).colwise().norm().mean(), 0.5F);
  EXPECT_GT((mirrored(features) - features).colwise().norm().mean(), 5.0F);
}

TEST(Fpfh, EdgeCases) {
  EXPECT_EQ(fpfh({}, 0.1).cols(), 0);
  EXPECT_EQ(fpfh({{{0, 0, 0}}, {{0, 0, 1}}}, 0.1).col(0).sum(), 0);
  const PointCloud same{std::vector<Eigen::Vector3d>(5, {0, 0, 0}),
                        std::vector<Eigen::Vector3d>(5, {0, 0, 1})};
  EXPECT_TRUE(fpfh(same, 0.1).allFinite());
  EXPECT_THROW(fpfh(same, 0), BadInput);
  EXPECT_THROW(fpfh({same.points, {}}, 0.1), BadInput);
}

TEST(MutualMatches, AreThoseOfExhaustiveSearch) {
  RandomStream random(5, "features");
  Features a(kFpfhBins, 300), b(kFpfhBins, 500);
  for (auto* f : {&a, &b}) {
    for (Eigen::Index i = 0; i < f->size(); ++i) {
      f->data()[i] = static_cast<float>(random.uniform());
    }
  }
  for (int i = 0; i < 100; ++i) b.col(4 * i) = a.col(2 * i) + 0.01F * b.col(4 * i);
  const auto matches = mutual_matches(a, b, 2);
  std::set<std::pair<int, int>> expected;
  for (int i = 0; i < 300; ++i) {
    Eigen::Index j = 0, back = 0;
    (b.colwise() - a.col(i)).colwise().squaredNorm().minCoeff(&j);
    (a.colwise() - b.col(j)).colwise().squaredNorm().minCoeff(&back);
    if (back == i) expected.emplace(i, static_cast<int>(j));
  }
  ASSERT_EQ(matches.size(), expected.size());
  for (const auto& match : matches) EXPECT_TRUE(expected.contains({match.source, match.target}));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(expected.contains({2 * i, 4 * i}));
  EXPECT_TRUE(mutual_matches(a, Features(kFpfhBins, 0)).empty());
}

}  // namespace
}  // namespace palpate::geometry
