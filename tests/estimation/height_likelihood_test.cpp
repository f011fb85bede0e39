// SPDX-License-Identifier: Apache-2.0
#include "estimation/height_likelihood.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/estimation/estimate.hpp"
#include "palpate/estimation/height_probe.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::estimation {
namespace {

/// The flat hand over the origin, its lowest part at a height above the table.
hand::HandReading flat_at(double height) {
  const hand::Description& model = skills::soft_shadow();
  const hand::FlatHand& flat = model.postures.flat;
  hand::HandReading reading;
  reading.joints = hand::joints_in_free_flexion(model, flat.positions);
  reading.mount.ypr = {0, flat.attitude.pitch, flat.attitude.roll};
  reading.mount.xyz.head<2>() = -flat.center;
  reading.mount.xyz.z() = height - lowest_of_hand(model, reading);
  return reading;
}

geometry::KnownObject box_of(double x, double y, double z) {
  return geometry::make_known_object("a box", geometry::box_mesh({x, y, z}), 0.2);
}

std::vector<double> heights_of(const geometry::KnownObject& object, const PlaceOnTable& place) {
  return stopping_heights(object, object.stable_poses[0], skills::soft_shadow(), flat_at(0.3),
                          place);
}

TEST(StoppingHeights, APlateUnderTheWholeHandStopsItAtItsTop) {
  const auto plate = box_of(0.39, 0.39, 0.05);
  const auto heights = heights_of(plate, {{0, 0}, 0.01});
  EXPECT_GT(heights.size(), 30u);
  for (const double height : heights) EXPECT_NEAR(height, 0.05, 0.002);
}

TEST(StoppingHeights, WhatFitsBetweenTheFingersStopsTheHandByItsPalm) {
  hand::Description two_fingers = skills::soft_shadow();
  two_fingers.spheres.clear();
  const hand::HandReading reading = flat_at(0.3);
  const auto T_mount_link = hand::forward_kinematics(two_fingers, reading.joints);
  const Eigen::Isometry3d T_link_world = (reading.mount.pose() * T_mount_link[0]).inverse();
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.03, 0, 0.3), Eigen::Vector3d(-0.03, 0, 0.3),
                                   Eigen::Vector3d(0, 0, 0.34)}) {
    two_fingers.spheres.push_back({0, T_link_world * p, 0.01});
  }
  const auto rod = box_of(0.012, 0.012, 0.11);
  const geometry::StablePose standing{Eigen::Matrix3d::Identity(), 0.055, 1};
  for (const double height : stopping_heights(rod, standing, two_fingers, reading, {{0, 0}, 0})) {
    EXPECT_NEAR(height, 0.11 - 0.04, 0.002);
  }
}

TEST(StoppingHeights, OfAnObjectWhosePoseIsKnown) {
  const auto box = box_of(0.12, 0.12, 0.1);
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.05));
  const auto stopped = [&] {
    return stopping_height(box, T_world_object, skills::soft_shadow(), flat_at(0.3));
  };
  EXPECT_NEAR(stopped(), 0.1, 0.002);
  T_world_object.translation().x() = 0.6;
  EXPECT_EQ(stopped(), 0);
}

TEST(ProbableTop, IsThatOfTheStablePoseThatStopsTheHandWhereItWas) {
  const geometry::ObjectModel box(box_of(0.05, 0.094, 0.175));
  const PoseEstimator estimator(box, {}, 1);
  for (const double height : {0.05, 0.094, 0.175}) {
    EventLog log;
    log.readings.push_back(flat_at(height));
    log.moments.push_back({TouchEvent::height_probed, 0});
    EXPECT_NEAR(estimator.probable_top(skills::soft_shadow(), log), height, 1e-6);
  }
}

TEST(StoppingHeights, AHandBesideTheObjectIsStoppedByTheTable) {
  for (const double height : heights_of(box_of(0.05, 0.05, 0.05), {{0.6, 0}, 0.02})) {
    EXPECT_EQ(height, 0);
  }
}

TEST(ProbedHeightLikelihoods, AreGreatestForTheStablePoseThatIsAsTall) {
  const auto box = box_of(0.05, 0.094, 0.175);
  for (std::size_t i = 0; i < box.stable_poses.size(); ++i) {
    const double top = geometry::top_of(box, box.stable_poses[i]);
    const auto likelihoods =
        probed_height_likelihoods(box, skills::soft_shadow(), flat_at(top), {{0, 0}, 0.02}, 0.005);
    ASSERT_EQ(likelihoods.size(), box.stable_poses.size());
    const double most = *std::max_element(likelihoods.begin(), likelihoods.end());
    EXPECT_NEAR(likelihoods[i], most, 0.01) << "probed " << top;
    for (std::size_t j = 0; j < likelihoods.size(); ++j) {
      const double other = geometry::top_of(box, box.stable_poses[j]);
      if (std::abs(other - top) > 0.02) {
        EXPECT_LT(likelihoods[j], 0.5 * most);
      }
      EXPECT_GT(likelihoods[j], 0) << "something else may have stopped it";
    }
  }
}

}  // namespace
}  // namespace palpate::estimation
