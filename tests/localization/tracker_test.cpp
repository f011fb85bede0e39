// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/tracking/tracker.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "localization/scenes.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kTick = 0.01;  // s

Posterior at(const Eigen::Isometry3d& T, double weight = 1) {
  Posterior posterior;
  Mode mode;
  mode.T_frame_object = T;
  mode.weight = weight;
  mode.covariance = Matrix6d::Identity() * 1e-5;
  posterior.modes.push_back(mode);
  return posterior;
}

/// Contacts that stick to an object which turns and moves evenly.
class Moving {
 public:
  Moving(const std::string& name, std::uint64_t seed) : random_(seed), model_(model_of(name)) {
    SceneOptions options;
    options.contacts = 6;
    options.point_noise = options.normal_noise = 0;
    const Scene scene = make_scene(model_, options, RandomStream(seed));
    truth = scene.truth;
    for (auto contact : scene.evidence.contacts) {
      contact.p = truth.inverse() * contact.p;
      contact.n = truth.linear().transpose() * contact.n;
      tips_.push_back(contact);
    }
  }

  TrackFrame next() {
    const Eigen::Vector3d w(0.2, -0.1, 0.25), v(0.01, 0.015, -0.005);
    truth.linear() = exp_so3(kTick * w) * truth.linear();
    truth.translation() += kTick * v;
    TrackFrame frame;
    frame.time = time_ += kTick;
    for (auto contact : tips_) {
      const Eigen::Vector3d p = truth * contact.p;
      frame.velocities.push_back(v + w.cross(p - truth.translation()));
      contact.p = p + 0.001 * random_.normal3();
      const Eigen::Matrix3d tangent = frame_with_z(truth.linear() * contact.n);
      contact.n = (tangent.col(2) +
                   0.1745 * (random_.normal() * tangent.col(0) + random_.normal() * tangent.col(1)))
                      .normalized();
      contact.point_sigma = 0.001;
      contact.normal_sigma = 0.1745;
      frame.contacts.push_back(contact);
    }
    return frame;
  }

  void slip() {
    truth.linear() = exp_so3(0.1745 * random_.unit_vector()) * truth.linear();
    truth.translation() += 0.005 * random_.unit_vector();
    for (auto& tip : tips_) {
      const auto closest = mesh_of(model_).closest_point(tip.p);
      tip.p = closest.point;
      tip.n = closest.normal;
    }
  }

  const geometry::ObjectModel& model() const { return model_; }
  Eigen::Isometry3d truth;

 private:
  RandomStream random_;
  const geometry::ObjectModel& model_;
  std::vector<tactile::Contact> tips_;
  double time_ = 0;
};

TEST(Tracker, FollowsAMovingObject) {
  for (const char* name : {"mug", "box", "bracket"}) {
    Moving object(name, 3);
    Tracker tracker(object.model(), at(object.truth));
    for (int i = 0; i < 300; ++i) tracker.update(object.next());
    const auto& best = tracker.posterior().modes.front();
    EXPECT_TRUE(within_tolerance(
        pose_error(best.T_frame_object, object.truth, object.model().object().symmetries)))
        << name;
    EXPECT_EQ(tracker.slips(), 0) << name;
  }
}

TEST(Tracker, FindsTheObjectAgainAfterASlip) {
  constexpr int kSlips = 20;
  int noticed = 0, back = 0;
  for (int i = 0; i < kSlips; ++i) {
    Moving object("box", static_cast<std::uint64_t>(50 + i));
    Tracker tracker(object.model(), at(object.truth));
    for (int k = 0; k < 60; ++k) tracker.update(object.next());
    object.slip();
    for (int k = 0; k < 20; ++k) tracker.update(object.next());
    noticed += tracker.slips() > 0;
    const auto& best = tracker.posterior().modes.front();
    back += within_tolerance(
        pose_error(best.T_frame_object, object.truth, object.model().object().symmetries));
  }
  // Where 0.9 of the slips are to be found again, fewer than 15 of 20 are in 1 % of such tests.
  EXPECT_GE(noticed, 15);
  EXPECT_GE(back, 15);
}

TEST(Tracker, DistinguishesTheNoiseOfVelocitiesFromSliding) {
  const auto uncertainty = [](double velocity_noise) {
    Moving object("box", 8);
    TrackerOptions options;
    options.velocity_noise = velocity_noise;
    Tracker tracker(object.model(), at(object.truth), options);
    RandomStream random(8);
    for (int k = 0; k < 200; ++k) {
      TrackFrame frame = object.next();
      for (auto& velocity : frame.velocities) velocity += 0.002 * random.normal3();
      tracker.update(frame);
    }
    return tracker.posterior().modes.front().covariance.trace();
  };
  EXPECT_LT(uncertainty(0.002), uncertainty(1e-5));  // all of it is taken for sliding
}

TEST(Tracker, PrefersTheModeThatKeepsExplaining) {
  Moving object("bracket", 4);
  Posterior start = at(object.truth, 0.3);
  Eigen::Isometry3d wrong = object.truth;
  wrong.linear() = wrong.linear() * exp_so3({0, 0, 1.5});
  start.modes.push_back(at(wrong, 0.7).modes.front());
  Tracker tracker(object.model(), start);
  for (int i = 0; i < 100; ++i) tracker.update(object.next());
  const auto& best = tracker.posterior().modes.front();
  EXPECT_GT(best.weight, 0.95);
  EXPECT_TRUE(within_tolerance(pose_error(best.T_frame_object, object.truth, {})));
}

TEST(Tracker, IgnoresFramesOutOfOrder) {
  Moving object("box", 5);
  Tracker tracker(object.model(), at(object.truth));
  tracker.update(object.next());
  TrackFrame late = object.next();
  tracker.update(object.next());
  const Eigen::Isometry3d before = tracker.posterior().modes.front().T_frame_object;
  tracker.update(late);
  EXPECT_TRUE(tracker.posterior().modes.front().T_frame_object.isApprox(before, 0));
}

TEST(Tracker, GrowsUncertainWithoutContacts) {
  Moving object("box", 6);
  Tracker tracker(object.model(), at(object.truth));
  const double before = tracker.posterior().modes.front().covariance.trace();
  tracker.update({0.01, {}, {}});
  tracker.update({0.11, {}, {}});
  EXPECT_GT(tracker.posterior().modes.front().covariance.trace(), before);
}

TEST(Tracker, IsNotSureOfWhatItHasNotSeenForLong) {
  Moving object("box", 6);
  Tracker silent(object.model(), at(object.truth)), unheard(object.model(), at(object.truth));
  EXPECT_GT(best_probability(silent.posterior()), 0.97);
  for (int i = 0; i < 100; ++i) silent.update({0.1 * i, {}, {}});
  EXPECT_LT(best_probability(silent.posterior()), 0.1);
  EXPECT_EQ(silent.posterior().status, PoseStatus::ambiguous);
  unheard.update({0, {}, {}});
  unheard.update({3600, {}, {}});
  EXPECT_LT(best_probability(unheard.posterior()), 0.01);
}

// The contacts of a body of revolution say nothing of its spin, however long they last.
TEST(Tracker, KeepsAFreeAxisAndCarriesItAlong) {
  Moving object("bottle", 3);
  Posterior start = at(object.truth);
  const Eigen::Vector3d axis(0, 0, 1);
  const double extent = 2;
  start.modes[0].free_axis = {object.truth.translation(), object.truth.linear() * axis, extent};
  Tracker tracker(object.model(), start);
  for (int i = 0; i < 100; ++i) tracker.update(object.next());
  const Mode& mode = tracker.posterior().modes.front();
  ASSERT_TRUE(mode.free_axis);
  EXPECT_GT(mode.free_axis->direction.dot(object.truth.linear() * axis), std::cos(3 * kDegree));
  EXPECT_LT((mode.free_axis->point - object.truth.translation()).norm(), 0.003);
  EXPECT_EQ(mode.free_axis->extent, extent);
  EXPECT_LT(best_probability(tracker.posterior()), 0.1);
}

TEST(Tracker, RefusesBadInput) {
  Moving object("box", 7);
  EXPECT_THROW(Tracker(object.model(), Posterior{}), BadInput);
  Posterior weightless = at(object.truth);
  weightless.modes.front().weight = 0;
  EXPECT_THROW(Tracker(object.model(), weightless), BadInput);
  Tracker tracker(object.model(), at(object.truth));
  TrackFrame frame = object.next();
  frame.velocities.pop_back();
  EXPECT_THROW(tracker.update(frame), BadInput);
  frame = object.next();
  frame.velocities[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(tracker.update(frame), BadInput);
  frame = object.next();
  frame.contacts[0].p.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(tracker.update(frame), BadInput);
}

}  // namespace
}  // namespace palpate::localization
