// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/camera.hpp"

#include <gtest/gtest.h>

#include "palpate/core/random.hpp"

namespace palpate::learning {
namespace {

TEST(PinholeCamera, ProjectsByHand) {
  const PinholeCamera camera;
  // 600 (0.1, -0.2) / 0.5 + (320, 240)
  EXPECT_LT((camera.project({0.1, -0.2, 0.5}) - Eigen::Vector2d(440, 0)).norm(), 1e-12);
  EXPECT_LT((camera.project({0, 0, 3}) - camera.center).norm(), 1e-12);
}

TEST(PinholeCamera, ARayGoesThroughItsPixelAtEveryDepth) {
  PinholeCamera camera;
  camera.focal = 450;
  camera.center = {300, 250};
  RandomStream random(4);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d pixel(random.uniform(0, 640), random.uniform(0, 480));
    const Eigen::Vector3d ray = camera.ray(pixel);
    EXPECT_EQ(ray.z(), 1);
    EXPECT_LT((camera.project(random.uniform(0.1, 5) * ray) - pixel).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace palpate::learning
