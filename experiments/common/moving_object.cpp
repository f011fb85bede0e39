// SPDX-License-Identifier: Apache-2.0
#include "moving_object.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/core/se3.hpp"

namespace palpate::experiment {
namespace {

constexpr double kTurning = 0.349066, kMoving = 0.02;  // rms a second: 20 deg, m
constexpr double kMotionTime = 1.0, kSlideTime = 0.5;  // s, correlation
constexpr double kVelocityNoise = 0.002;               // m/s per axis

}  // namespace

Wandering::Wandering(double time, RandomStream& random) : keep_(std::exp(-kFrame / time)) {
  value_ = random.normal3();
}

const Eigen::Vector3d& Wandering::next(RandomStream& random) {
  value_ = keep_ * value_ + std::sqrt(1 - keep_ * keep_) * random.normal3();
  return value_;
}

MovingObject::MovingObject(const Subject& subject, const TouchSetting& setting, RandomStream random)
    : subject_(subject),
      setting_(setting),
      random_(random),
      turning_(kMotionTime, random_),
      moving_(kMotionTime, random_) {
  T_.linear() = random_.rotation();
  place_fingertips();
}

localization::TrackFrame MovingObject::next(double time) {
  const double axis = 1 / std::sqrt(3.0);
  const Eigen::Vector3d w = axis * kTurning * turning_.next(random_);
  const Eigen::Vector3d v = axis * kMoving * moving_.next(random_);
  T_.linear() = exp_so3(kFrame * w) * T_.linear();
  T_.translation() += kFrame * v;
  localization::TrackFrame frame;
  frame.time = time;
  for (TouchingTip& tip : tips_) {
    Eigen::Vector3d slide = setting_.sliding / std::sqrt(2.0) * tip.slide.next(random_);
    slide -= slide.dot(tip.n) * tip.n;
    settle(tip, tip.p + kFrame * slide);
    const Eigen::Vector3d p = T_ * tip.p;
    frame.contacts.push_back(sensed_contact(tip));
    frame.velocities.push_back(v + w.cross(p - T_.translation()) + T_.linear() * slide +
                               kVelocityNoise * random_.normal3());
  }
  return frame;
}

void MovingObject::slip() {
  std::vector<Eigen::Vector3d> held;
  for (const TouchingTip& tip : tips_) held.push_back(T_ * tip.p);
  T_.linear() = exp_so3(kSlipAngle * random_.unit_vector()) * T_.linear();
  T_.translation() += kSlipWay * random_.unit_vector();
  for (std::size_t i = 0; i < tips_.size(); ++i) settle(tips_[i], T_.inverse() * held[i]);
}

/// Five spread over the surface.
void MovingObject::place_fingertips() {
  const auto& surface = subject_.model.surface();
  std::vector<Eigen::Vector3d> chosen;
  for (int i = 0; i < 5; ++i) {
    Eigen::Vector3d best = surface[random_.index(surface.size())].p.cast<double>();
    double most = -1;
    for (int attempt = 0; attempt < 8; ++attempt) {
      const Eigen::Vector3d p = surface[random_.index(surface.size())].p.cast<double>();
      double least = 1;
      for (const auto& other : chosen) least = std::min(least, (p - other).norm());
      if (least <= most) continue;
      most = least;
      best = p;
    }
    chosen.push_back(best);
    TouchingTip tip{best,
                    {},
                    Wandering(kSlideTime, random_),
                    Wandering(kNoiseTime, random_),
                    Wandering(kNoiseTime, random_)};
    settle(tip, best);
    tips_.push_back(tip);
  }
}

void MovingObject::settle(TouchingTip& tip, const Eigen::Vector3d& near) const {
  const auto closest = subject_.mesh.closest_point(near);
  tip.p = closest.point;
  tip.n = closest.normal;
}

tactile::Contact MovingObject::sensed_contact(TouchingTip& tip) {
  tactile::Contact contact;
  const double share = setting_.correlated ? std::sqrt(1 - kCorrelatedShare) : 1.0;
  const double kept = setting_.correlated ? std::sqrt(kCorrelatedShare) : 0.0;
  contact.p = T_ * tip.p;
  contact.n = T_.linear() * tip.n;
  const Eigen::Vector3d tilt = kept * tip.normal_error.next(random_) + share * random_.normal3();
  const Eigen::Vector3d across = tilt - tilt.dot(contact.n) * contact.n;
  contact.n = (contact.n + kNormalNoise * across).normalized();
  contact.p += kPointNoise * (kept * tip.point_error.next(random_) + share * random_.normal3());
  return contact;
}

}  // namespace palpate::experiment
