// SPDX-License-Identifier: Apache-2.0
// Add an estimator of contact normals: a class derived from NormalEstimator, and a test on a
// surface whose normal is known.
#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"

namespace palpate::tactile {
namespace {

/// Normal from the force alone, as if there were no friction: the mean direction of late forces.
class ForceDirection : public NormalEstimator {
 public:
  explicit ForceDirection(double time_constant = 0.1) : time_constant_(time_constant) {}

  NormalEstimate update(const FingerSample& sample) override {
    const double elapsed = sample.time - estimate_.time;
    estimate_.time = sample.time;
    if (!sample.flags.usable()) {
      if (estimate_.status != NormalStatus::none) estimate_.status = NormalStatus::held;
      return estimate_;
    }
    const double share =
        estimate_.status == NormalStatus::none ? 1 : -std::expm1(-elapsed / time_constant_);
    mean_ += share * (-sample.f - mean_);  // the finger pushes against the outward normal
    estimate_.n = mean_.normalized();
    estimate_.status = NormalStatus::tracked;
    return estimate_;
  }

 private:
  double time_constant_;  // s
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  NormalEstimate estimate_;
};

/// A fingertip that rubs to and fro along x with friction 0.3 on the plane z = 0.
FingerSample rubbing(double time, RandomStream& random) {
  const bool forth = std::fmod(time, 0.1) < 0.05;
  FingerSample sample;
  sample.time = time;
  sample.p.setZero();
  sample.f = Eigen::Vector3d(forth ? 0.6 : -0.6, 0, -2) + 0.05 * random.normal3();
  return sample;
}

TEST(ForceDirection, FrictionOfToAndFroCancels) {
  RandomStream random(1, "rubbing");
  ForceDirection estimator;
  NormalEstimate estimate;
  for (int tick = 0; tick < 100; ++tick) estimate = estimator.update(rubbing(0.01 * tick, random));
  EXPECT_EQ(estimate.status, NormalStatus::tracked);
  EXPECT_GT(estimate.n.z(), std::cos(std::atan(0.3) / 2));  // half the angle of friction
}

TEST(ForceDirection, HoldsItsEstimateThroughASampleOfNoUse) {
  RandomStream random(2, "rubbing");
  ForceDirection estimator;
  const NormalEstimate before = estimator.update(rubbing(0, random));
  FingerSample useless = rubbing(0.01, random);
  useless.flags.set(SampleFlag::no_contact);
  const NormalEstimate after = estimator.update(useless);
  EXPECT_EQ(after.status, NormalStatus::held);
  EXPECT_EQ(after.n, before.n);
}

}  // namespace
}  // namespace palpate::tactile
