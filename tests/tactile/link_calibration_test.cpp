// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/calibration/link_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::tactile {
namespace {

constexpr int kLinksAFinger = 3;
constexpr double kLinkError = 0.002;  // m

/// Five fingers of three links, 40 mm each, which bend about y and spread about z at the knuckle.
hand::Description three_link_hand() {
  hand::Description hand = hand::shadow_hand();
  hand.links.push_back({"palm", -1, Eigen::Isometry3d::Identity(), Eigen::Vector3d::Zero(), -1});
  hand.palm = 0;
  int joint = 0;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    int parent = 0;
    for (int i = 0; i < kLinksAFinger; ++i) {
      hand::Link link;
      link.parent = parent;
      link.joint = joint++ % hand::kShadowJoints;
      link.axis = i == 0 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
      link.T_parent_link.translation() = Eigen::Vector3d(0.04, i == 0 ? 0.02 * finger : 0, 0);
      parent = static_cast<int>(hand.links.size());
      hand.links.push_back(link);
    }
    hand.fingers[static_cast<std::size_t>(finger)].link = parent;
  }
  hand.kinematic_error = kLinkError;
  return hand;
}

Eigen::Vector3d place(const hand::Description& hand, const TipPosture& tip,
                      const Eigen::Vector3d& p) {
  const int link = hand.fingers[static_cast<std::size_t>(tip.finger)].link;
  return hand::forward_kinematics(hand, tip.joints)[static_cast<std::size_t>(link)] * p;
}

TipPosture random_posture(int finger, RandomStream& random) {
  TipPosture tip{finger, hand::JointVector::Zero(hand::kShadowJoints)};
  for (int i = 0; i < hand::kShadowJoints; ++i) tip.joints[i] = random.uniform(-0.3, 1.2);
  return tip;
}

std::vector<TipPosture> random_postures(int count, std::uint64_t seed) {
  RandomStream random(seed, "postures");
  std::vector<TipPosture> tips;
  for (int i = 0; i < count; ++i) tips.push_back(random_posture(i % hand::kShadowFingers, random));
  return tips;
}

/// Touches of planes of any direction by a hand that is not as its model says.
std::vector<TipOnPlane> random_touches(const hand::Description& real, int count, double sigma,
                                       std::uint64_t seed) {
  RandomStream random(seed, "touches");
  std::vector<TipOnPlane> touches;
  for (int i = 0; i < count; ++i) {
    TipOnPlane touch;
    touch.tip = random_posture(i % hand::kShadowFingers, random);
    touch.p = {0.02, 0, -0.005};
    touch.sigma = sigma;
    const Eigen::Vector3d p = place(real, touch.tip, touch.p);
    touch.T_base_plane.linear() = frame_with_z(random.unit_vector());
    touch.T_base_plane.translation() = p;
    touch.p += sigma * random.normal3();
    touches.push_back(touch);
  }
  return touches;
}

double mean_square_error(const hand::Description& believed, const hand::Description& real,
                         const std::vector<TipPosture>& uses) {
  double sum = 0;
  for (const auto& tip : uses) {
    const Eigen::Vector3d p(0.02, 0, 0);
    sum += (place(believed, tip, p) - place(real, tip, p)).squaredNorm();
  }
  return sum / static_cast<double>(uses.size());
}

TEST(CalibrateLinks, FindsTheHandFromManyExactTouches) {
  const hand::Description real = three_link_hand();
  RandomStream random(1, "links");
  const hand::Description drawn = hand::with_perturbed_links(real, kLinkError, random);
  const auto uses = random_postures(50, 2);
  const auto calibrated = calibrate_links(drawn, random_touches(real, 400, 1e-6, 3), uses);
  EXPECT_GT(std::sqrt(mean_square_error(drawn, real, uses)), 0.001);
  EXPECT_LT(std::sqrt(mean_square_error(calibrated, real, uses)), 1e-5);
  EXPECT_LT(calibrated.kinematic_error, 1e-5);
}

TEST(CalibrateLinks, StatesWhatIsLeftOfTheError) {
  const hand::Description real = three_link_hand();
  const auto uses = random_postures(50, 4);
  double stated = 0, found = 0;
  for (std::uint64_t seed = 10; seed < 60; ++seed) {
    RandomStream random(seed, "links");
    const hand::Description drawn = hand::with_perturbed_links(real, kLinkError, random);
    const auto calibrated = calibrate_links(drawn, random_touches(real, 30, 0.0003, seed), uses);
    stated += 3 * std::pow(link_offset_sigma(calibrated, 0), 2);
    found += mean_square_error(calibrated, real, uses);
  }
  // 50 hands of some 20 effective unknowns each: the ratio's standard error is about 0.05.
  EXPECT_NEAR(found / stated, 1.0, 0.2);
}

TEST(CalibrateLinks, LeavesTheHandWithoutTouchesUsesOrDoubt) {
  const hand::Description hand = three_link_hand();
  const auto touches = random_touches(hand, 5, 0.0003, 1);
  const auto uses = random_postures(5, 1);
  hand::Description certain = hand;
  certain.kinematic_error = 0;
  EXPECT_EQ(calibrate_links(hand, {}, uses).kinematic_error, kLinkError);
  EXPECT_EQ(calibrate_links(hand, touches, {}).kinematic_error, kLinkError);
  EXPECT_EQ(calibrate_links(certain, touches, uses).kinematic_error, 0);
}

TEST(CalibrateLinks, RefusesTouchesThatCannotBe) {
  const hand::Description hand = three_link_hand();
  const auto uses = random_postures(5, 1);
  const auto good = random_touches(hand, 1, 0.0003, 1)[0];
  const auto refuses = [&](const auto& spoil) {
    TipOnPlane touch = good;
    spoil(touch);
    EXPECT_THROW(calibrate_links(hand, std::vector{touch}, uses), BadInput);
    EXPECT_THROW(choose_touches(hand, std::vector{touch}, 1, uses), BadInput);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuses([](TipOnPlane& touch) { touch.tip.finger = 5; });
  refuses([](TipOnPlane& touch) { touch.tip.finger = -1; });
  refuses([](TipOnPlane& touch) { touch.sigma = 0; });
  refuses([&](TipOnPlane& touch) { touch.sigma = nan; });
  refuses([&](TipOnPlane& touch) { touch.p.x() = nan; });
  refuses([&](TipOnPlane& touch) { touch.tip.joints[3] = nan; });
  refuses([](TipOnPlane& touch) { touch.plane.coeffs() *= 2; });
  hand::Description worse = hand;
  worse.kinematic_error = -0.002;
  EXPECT_THROW(calibrate_links(worse, std::vector{good}, uses), BadInput);
  std::vector<TipPosture> elsewhere = uses;
  elsewhere[0].finger = 7;
  EXPECT_THROW(calibrate_links(hand, std::vector{good}, elsewhere), BadInput);
}

TEST(DistanceFromPlane, IsThatOfTheTouchingPoint) {
  hand::Description hand = three_link_hand();
  TipOnPlane touch;
  touch.tip = {2, hand::JointVector::Zero(hand::kShadowJoints)};
  touch.p = {0.02, 0, -0.005};
  touch.plane = {Eigen::Vector3d::UnitZ(), 0.03};  // z = -30 mm
  EXPECT_NEAR(distance_from_plane(hand, touch), 0.025, 1e-12);
}

TEST(ChooseTouches, TakesEachOnceAndThoseThatTellMore) {
  const hand::Description hand = three_link_hand();
  const auto uses = random_postures(50, 5);
  const auto candidates = random_touches(hand, 300, 0.0003, 6);
  const auto chosen = choose_touches(hand, candidates, 25, uses);
  ASSERT_EQ(chosen.size(), 25u);
  EXPECT_EQ(std::set<std::size_t>(chosen.begin(), chosen.end()).size(), 25u);
  std::vector<TipOnPlane> best;
  for (const std::size_t i : chosen) best.push_back(candidates[i]);
  const std::vector<TipOnPlane> first(candidates.begin(), candidates.begin() + 25);
  EXPECT_LT(calibrate_links(hand, best, uses).kinematic_error,
            0.9 * calibrate_links(hand, first, uses).kinematic_error);
  EXPECT_EQ(choose_touches(hand, first, 100, uses).size(), first.size());
}

}  // namespace
}  // namespace palpate::tactile
