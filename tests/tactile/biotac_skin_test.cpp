// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error_message.hpp"
#include "palpate/core/random.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "palpate/tactile/biotac/sensor.hpp"
#include "palpate/tactile/biotac/skin.hpp"

namespace palpate::tactile {
namespace {

/// A contact somewhere on the skin, its force within friction.
hand::TipContact some_contact(RandomStream& random, const BiotacSkin& skin) {
  Eigen::Vector3d p(random.uniform(-0.013, 0.006), random.uniform(-0.007, 0.007), -0.007);
  p = skin.on_skin(p);
  const Eigen::Vector3d outward = skin.normal_at(p);
  const double normal = random.uniform(0.05, 8);
  Eigen::Vector3d shear = random.normal3();
  shear = (shear - shear.dot(outward) * outward).normalized() * random.uniform(0, 0.6) * normal;
  return {.p = p, .n = -outward, .f = normal * outward + shear};
}

TEST(BiotacSkin, CoversTheTipEvenly) {
  const BiotacSkin skin;
  const double area = 2 * M_PI * 0.007 * 0.021;
  EXPECT_NEAR(skin.areas().sum(), area, 1e-9);
  for (int i = 0; i < kTaxels; ++i) {
    const Eigen::Vector3d x = skin.points().col(i);
    const Eigen::Vector3d from_axis = x - Eigen::Vector3d(std::min(0.0, x.x()), 0, 0);
    EXPECT_NEAR(from_axis.norm(), 0.007, 1e-9);
    EXPECT_NEAR(skin.normals().col(i).dot(from_axis), 0.007, 1e-9);
  }
}

TEST(BiotacSkin, CarriesExactlyTheSolversForce) {
  const BiotacSkin skin;
  RandomStream random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const auto contact = some_contact(random, skin);
    const double radius = random.uniform(0.004, 0.1);
    const Eigen::Vector3d center = contact.p - radius * contact.n;
    const auto state = skin.press(
        {&contact, 1}, [&](const Eigen::Vector3d& x) { return (x - center).norm() - radius; });
    const double tolerance = std::max(0.05, 0.02 * contact.f.norm());
    EXPECT_LT((state.force - contact.f).norm(), tolerance);
    const Eigen::Vector3d shear = contact.f - contact.f.dot(contact.n) * contact.n;
    const Eigen::Vector3d measured = state.force - state.force.dot(contact.n) * contact.n;
    if (shear.norm() > 0.05) {
      EXPECT_LT(angle_between_deg(shear, measured), 5);
    }
  }
}

TEST(BiotacSkin, SumsTwoContacts) {
  const BiotacSkin skin;
  const std::vector<hand::TipContact> contacts = {
      {.p = {0.007, 0, 0}, .n = {-1, 0, 0}, .f = {1, 0.2, 0}},
      {.p = {-0.01, 0, -0.007}, .n = {0, 0, 1}, .f = {0.3, 0, -2}}};
  const auto state = skin.press(contacts);
  EXPECT_LT((state.force - Eigen::Vector3d(1.3, 0.2, -2)).norm(), 0.05);
}

TEST(BiotacSkin, KeepsShearWithinFriction) {
  const BiotacSkin skin;
  const hand::TipContact contact{.p = {0, 0, -0.007}, .n = {0, 0, 1}, .f = {3, 0, -1}};
  const auto state = skin.press({&contact, 1});
  for (int i = 0; i < kTaxels; ++i) {
    EXPECT_LE(state.shear.col(i).norm(), 0.8 * state.pressure[i] * (1 + 1e-9));
  }
  EXPECT_LT(state.force.x(), 1);  // of the 3 N that friction cannot hold
}

TEST(BiotacSkin, ReportsContactsBeyondIt) {
  const BiotacSkin skin;
  const hand::TipContact beyond{.p = {-0.05, 0, -0.007}, .n = {0, 0, 1}, .f = {0, 0, -1}};
  EXPECT_TRUE(skin.press({&beyond, 1}).off_skin);
  const hand::TipContact infinite{
      .p = {0, 0, 0}, .n = {0, 0, 1}, .f = {0, 0, -std::numeric_limits<double>::infinity()}};
  EXPECT_NE(error_message([&] {
              (void)skin.press({&infinite, 1});
            }).find("not finite"),
            std::string::npos);
}

BiotacSensorOptions noiseless() {
  BiotacSensorOptions options;
  options.noise = 0;
  return options;
}

TEST(BiotacSensor, ShowsRestWithoutTouch) {
  const BiotacSkin skin;
  BiotacSensor sensor(skin, noiseless(), RandomStream(1));
  const auto reading = sensor.step(SkinState{});
  EXPECT_EQ(reading.electrodes, electrode_rest());
  EXPECT_EQ(reading.pdc, 2410);
  EXPECT_EQ(reading.pac[0], 2000);
}

TEST(BiotacSensor, ElectrodesFallAtTheContactAndRiseElsewhere) {
  const BiotacSkin skin;
  BiotacSensor sensor(skin, noiseless(), RandomStream(1));
  const hand::TipContact contact{.p = {0.007, 0, 0}, .n = {-1, 0, 0}, .f = {3, 0, 0}};
  BiotacReading reading;
  for (int k = 0; k < 100; ++k) reading = sensor.step(skin.press({&contact, 1}));
  const Eigen::VectorXd change = reading.electrodes - electrode_rest();
  EXPECT_LT(change[6], -30);  // e7 lies at the tip
  EXPECT_GT(change[18], 3);   // e19 far back, lifted by the displaced fluid
  EXPECT_NEAR(reading.pdc - 2410, 60 * 3, 60 * 3 * 0.2);  // N of pressure exceed those of force
}

TEST(BiotacSensor, HearsChangesOfPressureOnly) {
  const BiotacSkin skin;
  BiotacSensor sensor(skin, noiseless(), RandomStream(1));
  const hand::TipContact contact{.p = {0, 0, -0.007}, .n = {0, 0, 1}, .f = {0, 0, -2}};
  const auto first = sensor.step(skin.press({&contact, 1}));
  EXPECT_GT(first.pac.back(), 2100);
  EXPECT_TRUE(first.pac_interpolated);
  BiotacReading later;
  for (int k = 0; k < 50; ++k) later = sensor.step(skin.press({&contact, 1}));
  EXPECT_NEAR(later.pac.back(), 2000, 2);
}

TEST(BiotacSensor, StaysWithinTwelveBits) {
  const BiotacSkin skin;
  BiotacSensor sensor(skin, {}, RandomStream(1));
  const hand::TipContact contact{.p = {0, 0, -0.007}, .n = {0, 0, 1}, .f = {0, 0, -500}};
  const auto reading = sensor.step(skin.press({&contact, 1}), 200);
  EXPECT_EQ(reading.pdc, 4095);
  EXPECT_GE(reading.electrodes.minCoeff(), 0);
  EXPECT_LE(reading.tdc, 4095);
}

}  // namespace
}  // namespace palpate::tactile
