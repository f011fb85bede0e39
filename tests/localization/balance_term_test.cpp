// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/balance_term.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "localization/scenes.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kWeight = 2;  // N

/// Pinched from both sides along y at a point, with 3 N, each side bearing half of the weight.
ForceBalance pinched_at(const Eigen::Vector3d& p) {
  ForceBalance balance;
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d n(0, side, 0);
    balance.pushes.push_back({p + 0.02 * n, n, -3 * n + Eigen::Vector3d(0, 0, 0.5 * kWeight)});
  }
  balance.weight = {0, 0, -kWeight};
  balance.torsional_friction_radius = 0;
  return balance;
}

Eigen::Vector3d centroid() { return model_of("bracket").object().mass_properties.centroid; }

SearchPose with_center_at(const Eigen::Vector3d& place) {
  SearchPose pose;
  pose.t = (place - centroid()).cast<float>();
  return pose;
}

double energy(const ForceBalance& balance, const SearchPose& pose, double scale = 1) {
  const BalanceTerm term(model_of("bracket"), balance, scale);
  return static_cast<double>(term.energy(pose, kNoBound));
}

TEST(BalanceTerm, TheCenterOfMassHangsBelowThePinch) {
  const ForceBalance balance = pinched_at({0.1, 0, 0.2});
  const double below = energy(balance, with_center_at({0.1, 0, 0.17}));
  EXPECT_NEAR(below, energy(balance, with_center_at({0.1, 0, 0.2})), 1e-4);  // at any height
  // m = x w about y; points 1 mm off change it by the vertical forces, half of the weight each
  const double x = 0.003;
  const double covariance = 1e-10 + 2 * 1e-6 * 0.25 * kWeight * kWeight;
  const double q = 0.5 * x * x * kWeight * kWeight / covariance;
  EXPECT_NEAR(energy(balance, with_center_at({0.1 + x, 0, 0.2})) - below, q, 0.1 * q);
}

TEST(BalanceTerm, TwistsOfSoftFingertipsHideTheMomentAboutTheirNormals) {
  ForceBalance balance = pinched_at({0, 0, 0});
  const auto aside = [&] {
    return energy(balance, with_center_at({0.01, 0, 0})) -
           energy(balance, with_center_at({0, 0, 0}));
  };
  const double hard = aside();
  balance.torsional_friction_radius = 0.01;
  EXPECT_LT(aside(), 0.1 * hard);
}

TEST(BalanceTerm, OtherSupportBoundsItsEnergy) {
  ForceBalance balance = pinched_at({0, 0, 0});
  const double far = energy(balance, with_center_at({0.05, 0, 0}));
  balance.other_support_prior = 0.5;
  EXPECT_LT(energy(balance, with_center_at({0.05, 0, 0})), far);
  EXPECT_LT(far, 50);  // q alone would be 2500
}

TEST(BalanceTerm, IsFiniteHoweverFarTheObject) {
  const ForceBalance balance = pinched_at({0, 0, 0});
  const BalanceTerm term(model_of("bracket"), balance, 1);
  for (const double x : {0.1, 0.3, 3.0}) {
    const SearchPose pose = with_center_at({x, 0, 0});
    EXPECT_TRUE(std::isfinite(term.energy(pose, kNoBound))) << x;
    NormalEquations equations;
    term.linearize(pose, equations);
    EXPECT_TRUE(equations.H.allFinite() && equations.g.allFinite()) << x;
  }
}

TEST(BalanceTerm, LinearizesItself) {
  RandomStream random(1, "poses");
  ForceBalance balance = pinched_at({0.01, 0.02, 0.03});
  balance.torsional_friction_radius = 0.002;
  balance.other_support_prior = 1e-6;
  const BalanceTerm term(model_of("bracket"), balance, 3.0);
  for (int i = 0; i < 20; ++i) {
    SearchPose pose;
    pose.R = turn_by(random.normal3().cast<float>());
    pose.t = (0.01 * random.normal3()).cast<float>() - pose.R * centroid().cast<float>();
    NormalEquations equations;
    term.linearize(pose, equations);
    for (int axis = 0; axis < 6; ++axis) {
      const auto moved = [&](float step) {
        Eigen::Matrix<float, 6, 1> x = Eigen::Matrix<float, 6, 1>::Zero();
        x[axis] = step;
        const SearchPose there{turn_by(x.head<3>()) * pose.R, pose.t + x.tail<3>()};
        return static_cast<double>(term.energy(there, kNoBound));
      };
      const float h = axis < 3 ? 0.01F : 0.0005F;
      const double slope = (moved(h) - moved(-h)) / (2 * static_cast<double>(h));
      EXPECT_NEAR(equations.g[axis], slope, 0.05 * std::abs(slope) + 0.3) << axis;
    }
  }
}

TEST(Localize, RefusesABalanceThatCannotBe) {
  Scene scene = make_scene(model_of("box"), {}, RandomStream(1, "scene"));
  const auto refuses = [&](const auto& spoil) {
    ForceBalance balance = pinched_at({0, 0, 0});
    spoil(balance);
    scene.evidence.balance = balance;
    EXPECT_THROW(localize(model_of("box"), scene.evidence, RandomStream(1)), BadInput);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuses([](ForceBalance& balance) { balance.weight.setZero(); });
  refuses([&](ForceBalance& balance) { balance.pushes[0].f.x() = nan; });
  refuses([&](ForceBalance& balance) { balance.pushes[1].p.x() = nan; });
  refuses([](ForceBalance& balance) { balance.other_support_prior = 1; });
  refuses([](ForceBalance& balance) { balance.point_sigma = 0; });
  refuses([](ForceBalance& balance) { balance.torsional_friction_radius = -1; });
  refuses([](ForceBalance& balance) { balance.pushes.clear(); });
  refuses([](ForceBalance& balance) { balance.pushes[0].n *= 2; });
}

}  // namespace
}  // namespace palpate::localization
