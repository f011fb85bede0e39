// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/free_space_term.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "localization/scenes.hpp"

namespace palpate::localization {
namespace {

constexpr double kRadius = 0.06;  // m, of a palm's ball: more than the distance field's padding

/// Energy of the box where it is drawn, with one ball beside a face, `clear` (m) off it.
double energy_beside(int axis, double clear, const Eigen::Vector3d& shift = {0, 0, 0}) {
  const geometry::ObjectModel& model = model_of("box");
  Evidence evidence;
  Eigen::Vector3d center = shift;
  center[axis] = static_cast<double>(model.bounds().max()[axis]) + clear + kRadius;
  evidence.free_space = {{center, kRadius}};
  const FreeSpaceTerm term(model, evidence, std::make_shared<FreeSpaceTerm::Balls>(model, evidence),
                           1);
  const SearchPose pose{Eigen::Matrix3f::Identity(), Eigen::Vector3f::Zero()};
  return static_cast<double>(term.energy(pose, kNoBound));
}

TEST(FreeSpaceTerm, ALargeBallBesideTheObjectIsNoPenetration) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double clear : {0.001, 0.01, 0.035}) {
      EXPECT_EQ(energy_beside(axis, clear), 0) << "axis " << axis << ", " << clear << " m clear";
    }
    EXPECT_GT(energy_beside(axis, -0.02), 1);
    EXPECT_GT(energy_beside(axis, -0.02), energy_beside(axis, -0.01));
  }
}

/// Balls are looked at in batches, of four at a time.
TEST(FreeSpaceTerm, IsTheSumOverItsBalls) {
  const geometry::ObjectModel& model = model_of("box");
  RandomStream random(3);
  const SearchPose pose{random.rotation().cast<float>(), Eigen::Vector3f(0.01F, -0.02F, 0.03F)};
  const auto energy_of = [&](const std::vector<FreeSphere>& balls) {
    Evidence evidence;
    evidence.free_space = balls;
    const FreeSpaceTerm term(model, evidence,
                             std::make_shared<FreeSpaceTerm::Balls>(model, evidence), 1);
    return static_cast<double>(term.energy(pose, kNoBound));
  };
  std::vector<FreeSphere> balls;
  double sum = 0;
  for (int i = 0; i < 71; ++i) {
    balls.push_back({0.07 * random.normal3(), 0.004});
    sum += energy_of({balls.back()});
    if (i % 7 != 0) continue;
    EXPECT_NEAR(energy_of(balls), sum, 1e-4 * sum) << balls.size() << " balls";
  }
  EXPECT_GT(sum, 1);
}

}  // namespace
}  // namespace palpate::localization
