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
    touch.T_mount_plane.linear() = frame_with_z(random.unit_vector());
    touch.T_mount_plane.translation() = p;
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
  const auto calibrated = calibrate_links(drawn, random_touches(real, 400, 1e-6, 3), uses).hand;
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
    const auto calibrated =
        calibrate_links(drawn, random_touches(real, 30, 0.0003, seed), uses).hand;
    stated += 3 * std::pow(link_offset_sigma(calibrated, 0), 2);
    found += mean_square_error(calibrated, real, uses);
  }
  // 50 hands of some 20 effective unknowns each: the ratio's standard error is about 0.05.
  EXPECT_NEAR(found / stated, 1.0, 0.2);
}

/// Touches of a table by a hand in random attitudes of its mount.
std::vector<TipOnPlane> table_touches(const hand::Description& real,
                                      const Eigen::Isometry3d& T_world_table, int count,
                                      std::uint64_t seed) {
  RandomStream random(seed, "table touches");
  std::vector<TipOnPlane> touches;
  for (int i = 0; i < count; ++i) {
    TipOnPlane touch;
    touch.tip = random_posture(i % hand::kShadowFingers, random);
    touch.p = {0.02, 0, -0.005};
    Eigen::Isometry3d T_world_mount = Eigen::Isometry3d::Identity();
    T_world_mount.linear() = random.rotation();
    T_world_mount.translation() << random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 0;
    // Lowered along the table's normal until the tip touches.
    const Eigen::Vector3d p =
        T_world_table.inverse() * T_world_mount * place(real, touch.tip, touch.p);
    T_world_mount.pretranslate(-p.z() * T_world_table.linear().col(2));
    touch.T_mount_plane = T_world_mount.inverse();
    touches.push_back(touch);
  }
  return touches;
}

TEST(CalibrateLinks, FindsHowTheHandIsMountedAndWhereTheTableIs) {
  const hand::Description drawn = three_link_hand();
  hand::Description real = drawn;
  const Vector6d twist = (Vector6d() << 0.004, -0.003, 0.002, 0.001, -0.0008, 0.0012).finished();
  real.links.front().T_parent_link = exp_se3(twist) * real.links.front().T_parent_link;
  Eigen::Isometry3d T_world_table = Eigen::Isometry3d::Identity();
  T_world_table.translation().z() = 0.004;
  T_world_table.rotate(Eigen::AngleAxisd(0.012, Eigen::Vector3d(0.6, 0.8, 0)));

  const auto uses = random_postures(50, 2);
  const auto touches = table_touches(real, T_world_table, 300, 3);
  const auto found = calibrate_links(drawn, touches, uses, {0.001, 0.005, 0.005, 0.0175});
  EXPECT_GT(std::sqrt(mean_square_error(drawn, real, uses)), 0.001);
  EXPECT_LT(std::sqrt(mean_square_error(found.hand, real, uses)), 1e-4);
  const Eigen::Isometry3d apart = found.T_believed_plane.inverse() * T_world_table;
  EXPECT_LT(std::abs(apart.translation().z()), 1e-4);
  EXPECT_LT(std::acos(std::min(1.0, apart.linear()(2, 2))), 1e-3);
}

TEST(CalibrateLinks, LeavesTheHandWithoutTouchesUsesOrDoubt) {
  const hand::Description hand = three_link_hand();
  const auto touches = random_touches(hand, 5, 0.0003, 1);
  const auto uses = random_postures(5, 1);
  hand::Description certain = hand;
  certain.kinematic_error = 0;
  EXPECT_EQ(calibrate_links(hand, {}, uses).hand.kinematic_error, kLinkError);
  EXPECT_EQ(calibrate_links(hand, touches, {}).hand.kinematic_error, kLinkError);
  EXPECT_EQ(calibrate_links(certain, touches, uses).hand.kinematic_error, 0);
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
  refuses([&](TipOnPlane& touch) { touch.T_mount_plane(1, 3) = nan; });
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
  touch.T_mount_plane.translation().z() = -0.03;
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
  EXPECT_LT(calibrate_links(hand, best, uses).hand.kinematic_error,
            0.9 * calibrate_links(hand, first, uses).hand.kinematic_error);
  EXPECT_EQ(choose_touches(hand, first, 100, uses).size(), first.size());
}

}  // namespace
}  // namespace palpate::tactile
