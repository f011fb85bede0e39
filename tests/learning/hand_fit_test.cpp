// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/hand_fit.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "data.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/learning/demonstrations/human_sequence.hpp"

namespace palpate::learning {
namespace {

PinholeCamera small_camera() { return {300, {160, 120}, 320, 240}; }

/// A hand with half-bent fingers, 60 cm from the camera, its back towards it.
HandState true_state(RandomStream& random) {
  HandState state;
  for (int i = 2; i < learning::kHumanJoints; ++i) {
    const auto& range = learning::human_ranges()[static_cast<std::size_t>(i)];
    state.joints[i] = range.low + random.uniform(0.35, 0.65) * (range.high - range.low);
  }
  state.shape.palm = random.uniform(0.9, 1.1);
  state.shape.fingers.fill(random.uniform(0.9, 1.1));
  state.T_camera_wrist.linear() = exp_so3(0.3 * random.unit_vector());
  state.T_camera_wrist.translation() << 0, -0.05, 0.6;
  return state;
}

HandImage image_of(const PinholeCamera& camera, const HandState& state, double noise,
                   RandomStream& random) {
  HandImage image;
  const auto keypoints = state.keypoints();
  for (int i = 0; i < learning::kHandKeypoints; ++i) {
    image.pixels.col(i) = camera.project(keypoints.col(i)) +
                          noise * Eigen::Vector2d(random.normal(), random.normal());
  }
  image.depth = render_depth(camera, state);
  image.mask = image.depth.array() > 0;
  return image;
}

HandState rough_start(const HandState& truth) {
  HandState start;
  start.T_camera_wrist.linear() =
      exp_so3(Eigen::Vector3d(0.15, -0.1, 0.1)) * truth.T_camera_wrist.linear();
  start.T_camera_wrist.translation() =
      truth.T_camera_wrist.translation() + Eigen::Vector3d(0.02, 0.01, 0.05);
  return start;
}

double keypoint_error(const HandState& a, const HandState& b) {
  return (a.keypoints() - b.keypoints()).colwise().norm().mean();
}

TEST(HandFit, DepthShowsTheNearestSurface) {
  RandomStream random(1);
  const PinholeCamera camera = small_camera();
  const HandState state = true_state(random);
  const auto depth = render_depth(camera, state);
  const auto keypoints = state.keypoints();
  for (int i = 0; i < learning::kHandKeypoints; ++i) {
    const Eigen::Vector2d pixel = camera.project(keypoints.col(i));
    const double seen = depth_at(camera, keypoints, state.shape, pixel);
    EXPECT_GT(seen, 0) << i;
    EXPECT_LT(seen, keypoints(2, i)) << i;
  }
  EXPECT_EQ(depth(0, 0), 0);
}

TEST(HandFit, KeypointsAndDepthGiveThePlaceOfAHandOfUnknownSize) {
  RandomStream random(2);
  const PinholeCamera camera = small_camera();
  for (int trial = 0; trial < 2; ++trial) {
    const HandState truth = true_state(random);
    const auto image = image_of(camera, truth, 0.5, random);
    const HandState start = rough_start(truth);
    const auto with_depth = fit_hand(camera, image, start);
    ASSERT_EQ(with_depth.status, HandFitStatus::ok);
    EXPECT_LT(with_depth.pixel_rms, 2);
    // Half a pixel is 1 mm at 0.6 m; how far a finger points to the camera shows less well.
    EXPECT_LT(keypoint_error(with_depth.state, truth), 0.012);
    // Keypoints alone cannot distinguish a large hand from a near one.
    HandImage flat = image;
    flat.depth.resize(0, 0);
    EXPECT_LT(keypoint_error(with_depth.state, truth),
              keypoint_error(fit_hand(camera, flat, start).state, truth));
  }
}

TEST(HandFit, MissingKeypointsAreLeftOut) {
  RandomStream random(3);
  const PinholeCamera camera = small_camera();
  const HandState truth = true_state(random);
  auto image = image_of(camera, truth, 0, random);
  for (const int i : {4, 8, 15}) {
    image.pixels.col(i).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  EXPECT_LT(keypoint_error(fit_hand(camera, image, rough_start(truth)).state, truth), 0.015);
  image.pixels.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(fit_hand(camera, image, rough_start(truth)).status, HandFitStatus::too_few_keypoints);
}

TEST(HandFit, TheMaskedDepthsCenterIsInTheHand) {
  RandomStream random(4);
  const PinholeCamera camera = small_camera();
  const HandState truth = true_state(random);
  auto image = image_of(camera, truth, 0, random);
  const auto center = masked_center(camera, image);
  ASSERT_TRUE(center);
  EXPECT_LT((*center - truth.keypoints().rowwise().mean()).norm(), 0.04);
  image.mask.setConstant(false);
  EXPECT_FALSE(masked_center(camera, image));
}

TEST(HandFit, PointsInSpaceAreMet) {
  RandomStream random(5);
  const HandState truth = true_state(random);
  const auto fit = fit_hand(truth.keypoints(), rough_start(truth), {.rest = 0, .size = 0});
  EXPECT_LT(fit.pixel_rms, 0.1);
}

TEST(HandFit, AHumansHandIsFittedWithinItsKeypointsNoise) {
  for (const auto& file : made_up_and_real("hand_joints.csv", "human_relocate/hand_joints.csv")) {
    const auto frames = read_keypoints(file);
    for (const std::size_t i : {20U, 60U, 100U}) {
      HandState start;
      start.T_camera_wrist.linear() = learning::palm_frame(frames[i]);
      start.T_camera_wrist.translation() = frames[i].col(0);
      // The detector's own bones differ by millimetres from any hand of this shape.
      EXPECT_LT(fit_hand(frames[i], start, {.rest = 0.5}).pixel_rms, 5) << file << ", frame " << i;
    }
  }
}

TEST(HandFit, RefusesImagesOfAnotherSize) {
  RandomStream random(6);
  const HandState truth = true_state(random);
  auto image = image_of(small_camera(), truth, 0, random);
  EXPECT_THROW(fit_hand(PinholeCamera{}, image, truth), BadInput);
  image.mask.resize(3, 3);
  EXPECT_THROW(fit_hand(small_camera(), image, truth), BadInput);
}

}  // namespace
}  // namespace palpate::learning
