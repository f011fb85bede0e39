// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/taxel_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tactile/biotac/normal.hpp"

namespace palpate::grasping {
namespace {

/// Only the taxels near the middle of the sensing side are loaded, all alike.
tactile::SkinState pressed_evenly(const tactile::BiotacSkin& skin, const Eigen::Vector3d& p,
                                  double reach) {
  tactile::SkinState state;
  for (Eigen::Index i = 0; i < tactile::kTaxels; ++i) {
    if ((skin.points().col(i) - p).norm() < reach) state.pressure[i] = 1e4;
  }
  return state;
}

TEST(TaxelContact, HasTheForcesOfTheTaxelsInTheirOwnFrames) {
  const tactile::BiotacSkin skin;
  tactile::SkinState state = pressed_evenly(skin, {-0.004, 0, -0.007}, 0.003);
  const TaxelGrasp grasp = taxel_grasp(skin, state);
  ASSERT_GT(grasp.contacts.size(), 3u);
  ASSERT_EQ(grasp.wrenches.size(), 6 * std::ssize(grasp.contacts));
  for (Eigen::Index k = 0; k < std::ssize(grasp.contacts); ++k) {
    const auto wrench = grasp.wrenches.segment<6>(6 * k);
    EXPECT_NEAR(wrench[3], 1e4 * skin.areas()[0], 1e-9);  // n points into the object
    EXPECT_LT(wrench.head<3>().norm() + wrench.tail<2>().norm(), 1e-9);
  }
}

TEST(TaxelContact, IsWhereTheObjectPresses) {
  const tactile::BiotacSkin skin;
  RandomStream random(3);
  std::vector<double> places;
  for (int trial = 0; trial < 200; ++trial) {
    Eigen::Vector3d p(random.uniform(-0.011, 0.005), random.uniform(-0.006, 0.006), -0.007);
    p = skin.on_skin(p);
    const Eigen::Vector3d outward = skin.normal_at(p);
    const double normal = random.uniform(0.3, 6);
    Eigen::Vector3d shear = random.normal3();
    shear = (shear - shear.dot(outward) * outward).normalized() * random.uniform(0, 0.5) * normal;
    const hand::TipContact contact{.p = p, .n = -outward, .f = normal * outward + shear};
    const double radius = random.uniform(0.006, 0.1);
    const Eigen::Vector3d center = p + radius * outward;
    const auto state = skin.press(
        {&contact, 1}, [&](const Eigen::Vector3d& x) { return (x - center).norm() - radius; });
    const auto found = contact_of_taxels(skin, state);
    ASSERT_TRUE(found);
    places.push_back((found->p - p).norm());
    EXPECT_LT((found->f - contact.f).norm(), std::max(0.05, 0.02 * contact.f.norm()));
    EXPECT_LT((skin.on_skin(found->p) - found->p).norm(), 1e-9);
  }
  EXPECT_LT(median(places), 0.0007);          // as inferred contacts are to be
  EXPECT_LT(quantile(places, 0.95), 0.0013);  // the taxels' spacing
}

/// Taxels on both flanks near the back, which push evenly and pull the same way.
tactile::SkinState pulled_at_the_back(const tactile::BiotacSkin& skin,
                                      const Eigen::Vector3d& shear) {
  const double radius = skin.options().radius;
  tactile::SkinState state = pressed_evenly(skin, {-0.011, radius, 0}, 0.002);
  state.pressure += pressed_evenly(skin, {-0.011, -radius, 0}, 0.002).pressure;
  for (Eigen::Index i = 0; i < tactile::kTaxels; ++i) {
    if (state.pressure[i] > 0) state.shear.col(i) = shear;
  }
  return state;
}

TEST(TaxelContact, IsNoneBehindTheSkin) {
  const tactile::BiotacSkin skin;
  const auto below = contact_of_taxels(skin, pulled_at_the_back(skin, {0, 0, -1e4}));
  ASSERT_TRUE(below);
  EXPECT_GE(below->p.x(), -skin.options().length);
  EXPECT_FALSE(contact_of_taxels(skin, pulled_at_the_back(skin, {-1e4, 0, -5e3})));
}

TEST(TaxelContact, IsNoneWithoutLoad) {
  EXPECT_FALSE(contact_of_taxels(tactile::BiotacSkin(), {}));
}

}  // namespace
}  // namespace palpate::grasping
