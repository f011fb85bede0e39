// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/contact_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"

namespace palpate::grasping {
namespace {

constexpr Friction kFriction = {.sliding = 0.5, .eccentricity = 0.01};

TEST(ContactModel, TransmitsNormalThenTangentsThenSpin) {
  Eigen::VectorXd wrench(6);
  wrench << 1, 2, 3, 4, 5, 6;  // m_n m_t m_o f_n f_t f_o
  const Eigen::VectorXd soft = transmission(ContactModel::soft_finger) * wrench;
  EXPECT_EQ(soft, Eigen::Vector4d(4, 5, 6, 1));
  EXPECT_EQ(transmission(ContactModel::hard_finger) * wrench, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ((transmission(ContactModel::frictionless) * wrench)(0), 4);
}

TEST(ContactModel, FrictionConeOfAHardFinger) {
  const auto slack = [](double n, double t, double o) {
    return cone_slack(ContactModel::hard_finger, kFriction, Eigen::Vector3d(n, t, o));
  };
  EXPECT_NEAR(slack(10, 3, 4), 0, 1e-12);  // 5 = mu 10
  EXPECT_NEAR(slack(10, 0, 0), 5, 1e-12);
  EXPECT_LT(slack(10, 4, 4), 0);
  EXPECT_LT(slack(-1, 0, 0), 0);
}

TEST(ContactModel, FrictionEllipsoidOfASoftFinger) {
  const auto inside = [](double n, double t, double o, double m) {
    return is_within_cone(ContactModel::soft_finger, kFriction, Eigen::Vector4d(n, t, o, m));
  };
  EXPECT_TRUE(inside(10, 0, 0, 0.0499));
  EXPECT_FALSE(inside(10, 0, 0, 0.0501));
  EXPECT_TRUE(inside(10, 3.99, 0, 0.03));  // 4^2 + (0.03 / 0.01)^2 = (mu 10)^2
  EXPECT_FALSE(inside(10, 4.01, 0, 0.03));
  EXPECT_FALSE(inside(0, 0, 0, 0.01));
}

TEST(ContactModel, WithoutFrictionItOnlyPushes) {
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  EXPECT_TRUE(is_within_cone(ContactModel::frictionless, kFriction, one(1)));
  EXPECT_FALSE(is_within_cone(ContactModel::frictionless, kFriction, one(-1)));
  EXPECT_TRUE(is_within_cone(ContactModel::frictionless, kFriction, one(-1), 1.5));
}

TEST(ContactModel, RejectsWhatIsNoForceOrFriction) {
  EXPECT_THROW(cone_slack(ContactModel::hard_finger, kFriction, Eigen::Vector4d::Ones()), BadInput);
  const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::nan(""));
  EXPECT_THROW(cone_slack(ContactModel::hard_finger, kFriction, nan), BadInput);
  EXPECT_THROW(cone_scale(ContactModel::hard_finger, {.sliding = -1}), BadInput);
  EXPECT_THROW(cone_scale(ContactModel::soft_finger, {.sliding = 1, .eccentricity = 0}), BadInput);
}

}  // namespace
}  // namespace palpate::grasping
