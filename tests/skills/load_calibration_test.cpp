// SPDX-License-Identifier: Apache-2.0
#include "skills/load_calibration.hpp"

#include <gtest/gtest.h>

#include "palpate/core/random.hpp"

namespace palpate::skills {
namespace {

TEST(LoadCalibration, FindsTheSensorsBiasAndTheWeightThatIsWronglyTakenOff) {
  const Eigen::Vector3d bias(0.2, -0.15, 0.3);
  const double weight = -0.8;
  RandomStream random(3);
  LoadCalibration calibration;
  for (int i = 0; i < 10; ++i) {
    hand::MountPosition mount;
    mount.ypr = {0, random.uniform(-0.3, 1.4), random.uniform(-1.6, 1.6)};
    const Eigen::Vector3d load = mount.pose().linear() * bias + weight * Eigen::Vector3d::UnitZ();
    calibration.add(mount, load + 0.03 * random.normal3());
  }
  EXPECT_LT((calibration.error().bias - bias).norm(), 0.1);
  EXPECT_NEAR(calibration.error().weight, weight, 0.1);
}

TEST(LoadCalibration, KnowsNoErrorBeforeAnyAttitude) {
  EXPECT_TRUE(LoadCalibration().error().bias.isZero());
  EXPECT_EQ(LoadCalibration().error().weight, 0);
}

}  // namespace
}  // namespace palpate::skills
