// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/fingers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/error.hpp"
#include "tactile/biotac/faults.hpp"

namespace palpate::tactile {
namespace {

constexpr double kLateGap = 2.5;     // periods
constexpr double kRestTime = 2;      // s in which rest follows the readings
constexpr double kRestPressure = 4;  // counts from rest, within which nothing touches
/// Standard deviations of misfit beyond which no contact explains the channels: without force, and
/// more with each newton of it, for the skin's model is the further off the more the skin yields.
constexpr double kMaxMisfit = 1.2, kMaxMisfitPerNewton = 1.0;
constexpr std::size_t kMeetingReadings = 30;  // before a touch, over which its way is taken
constexpr double kMinWay = 0.002;             // m, that a tip must have gone to count as moved
constexpr int kScalars = 3;                   // pdc, tdc, tac
using Channels = Eigen::Matrix<double, kScalars + kElectrodes, 1>;

Channels rested_channels(const BiotacReading& reading) {
  Channels channels;
  channels << reading.pdc, reading.tdc, reading.tac, reading.electrodes;
  return channels;
}

/// Moves the rest by a share of the way to a reading.
void approach(const BiotacReading& reading, double share, BiotacReading& rest) {
  const Channels moved =
      rested_channels(rest) + share * (rested_channels(reading) - rested_channels(rest));
  rest.pdc = moved[0];
  rest.tdc = moved[1];
  rest.tac = moved[2];
  rest.electrodes = moved.tail<kElectrodes>();
}

bool same(const BiotacReading& a, const BiotacReading& b) {
  return rested_channels(a) == rested_channels(b) && a.pac == b.pac;
}

}  // namespace

Eigen::Isometry3d biotac_mount(const hand::Description& hand, int finger) {
  const auto i = static_cast<std::size_t>(finger);
  const auto& tip = hand.fingers.at(i).tip;
  const Eigen::Vector3d forward = (tip.b - tip.a).normalized();
  const Eigen::Vector3d axis = hand.links[static_cast<std::size_t>(hand.fingers[i].link)].axis;
  // A turn about the axis moves the tip this way, towards what it is to touch.
  const Eigen::Vector3d sensing = axis.cross(forward).normalized();
  Eigen::Isometry3d T_link_sensor = Eigen::Isometry3d::Identity();
  T_link_sensor.linear() << forward, forward.cross(sensing), -sensing;
  T_link_sensor.translation() = tip.b;
  return T_link_sensor;
}

BiotacFinger::BiotacFinger(std::shared_ptr<const BiotacInverse> inverse)
    : inverse_(std::move(inverse)) {}

unsigned BiotacFinger::fault_flags(const BiotacReading& reading) {
  unsigned flags = count_flags(channels_of(reading));
  BiotacChannels others = BiotacChannels::Ones();
  others.head<2>() << reading.tdc, reading.tac;
  flags |= count_flags(others);
  if (last_) {
    const double step = reading.time - last_->time;
    if (step <= 0) flags |= bit(BiotacFlag::out_of_order);
    if (step > kLateGap * kBiotacPeriod) flags |= bit(BiotacFlag::late);
    if (same(reading, *last_)) flags |= bit(BiotacFlag::repeated);
  }
  for (std::size_t e = 0; e < still_.size(); ++e) {
    Stillness& still = still_[e];
    const auto k = static_cast<Eigen::Index>(e);
    if (!last_ || reading.electrodes[k] != last_->electrodes[k]) {
      still = {.frames = 0, .low = reading.pdc, .high = reading.pdc};
    }
    ++still.frames;
    still.low = std::min(still.low, reading.pdc);
    still.high = std::max(still.high, reading.pdc);
    if (still.frames >= kStuckFrames && still.high - still.low > kStuckPressure) {
      flags |= bit(BiotacFlag::stuck);
    }
  }
  return flags;
}

void BiotacFinger::learn_rest(const BiotacReading& reading) {
  ++rest_frames_;
  approach(reading, 1.0 / rest_frames_, rest_);
  if (rest_frames_ < kRestFrames) return;
  first_rest_ = rest_;
  decoder_.emplace(rest_, inverse_->sensor());
  decoded_time_ = reading.time;
}

void BiotacFinger::follow_rest(const BiotacReading& reading) {
  approach(reading, kBiotacPeriod / kRestTime, rest_);
  decoder_->set_rest(rest_);
}

BiotacEstimate BiotacFinger::step(const BiotacReading& reading, bool infer) {
  BiotacEstimate estimate{
      .flags = bit(BiotacFlag::missing), .contact = std::nullopt, .pressure = std::nullopt};
  if (!std::isfinite(reading.time)) return estimate;  // before it spoils the times of later ones
  estimate.flags = fault_flags(reading);
  if (estimate.flags & bit(BiotacFlag::out_of_order)) return estimate;
  last_ = reading;
  if (!biotac_usable(estimate.flags)) return estimate;
  if (!decoder_) {
    estimate.flags |= bit(BiotacFlag::no_rest);
    learn_rest(reading);
    return estimate;
  }
  // The line that takes the noise away may not run across what was missed.
  if (reading.time - decoded_time_ > kLateGap * kBiotacPeriod) decoder_->forget_window();
  const auto decoded = decoder_->step(reading);
  if (decoded) decoded_time_ = reading.time;
  if (far_from(channels_of(rest_), channels_of(first_rest_))) {
    estimate.flags |= bit(BiotacFlag::drifted);
  }
  if (decoded && std::abs(decoded->pressure) < kRestPressure) follow_rest(reading);
  if (decoded) estimate.pressure = decoded->pressure;
  if (!infer || !decoded) return estimate;
  estimate.contact = inverse_->estimate(*decoded);
  const double newtons = decoded->pressure / inverse_->sensor().pressure_gain;
  if (!estimate.contact) {
    estimate.flags |= bit(BiotacFlag::no_contact);
  } else if (estimate.contact->misfit > kMaxMisfit + kMaxMisfitPerNewton * newtons) {
    estimate.flags |= bit(BiotacFlag::unexplained);
    estimate.contact.reset();
  }
  return estimate;
}

void MeetingWay::follow(const Eigen::Vector3d& p_tip, bool touching) {
  if (!touching) {
    way_.reset();
  } else if (!touching_ && !places_.empty()) {
    const Eigen::Vector3d gone = p_tip - places_.front();
    if (gone.norm() > kMinWay) way_ = gone.normalized();
  }
  touching_ = touching;
  places_.push_back(p_tip);
  if (places_.size() > kMeetingReadings) places_.pop_front();
}

BiotacFingers::BiotacFingers(const hand::Description& hand,
                             std::shared_ptr<const BiotacInverse> inverse)
    : hand_(hand), pressure_gain_(inverse->sensor().pressure_gain) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    fingers_.emplace_back(inverse);
    mounts_.push_back(biotac_mount(hand, finger));
  }
  ways_.resize(fingers_.size());
}

BiotacFingers::TipPoses BiotacFingers::tip_poses(const hand::HandReading& reading) const {
  const auto T_mount_link = hand::forward_kinematics(hand_, reading.joints);
  TipPoses poses(hand_.fingers.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = reading.mount.pose() * T_mount_link[static_cast<std::size_t>(hand_.fingers[i].link)];
  }
  return poses;
}

std::vector<BiotacEstimate> BiotacFingers::step(const hand::HandReading& reading, bool infer) {
  if (reading.biotacs.size() != hand_.fingers.size()) {
    throw BadInput(fmt::format("the reading at {} s has the channels of {} BioTacs, not {}",
                               reading.time, reading.biotacs.size(), hand_.fingers.size()));
  }
  std::vector<BiotacEstimate> estimates(hand_.fingers.size());
  const TipPoses poses = tip_poses(reading);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    estimates[i] = fingers_[i].step(reading.biotacs[i], infer);
    if (!estimates[i].pressure) continue;
    ways_[i].follow(poses[i] * hand_.fingers[i].tip.b, *estimates[i].pressure > kRestPressure);
  }
  return estimates;
}

std::vector<BiotacEstimate> BiotacFingers::estimate(const hand::HandReading& reading) {
  return step(reading, true);
}

void BiotacFingers::follow(const hand::HandReading& reading) { step(reading, false); }

hand::TipContact BiotacFingers::in_link(const InferredContact& contact, int finger) const {
  const auto i = static_cast<std::size_t>(finger);
  const Eigen::Isometry3d& T = mounts_.at(i);
  const double radius = hand_.fingers.at(i).tip.radius;
  const double sigma = std::sqrt(contact.covariance.diagonal().head<2>().mean()) / radius;
  return {.p = T * contact.p,
          .n = T.linear() * contact.n,
          .f = T.linear() * contact.f,
          .point_sigma = radius * sigma * sigma,
          .normal_sigma = sigma};
}

std::optional<hand::TipContact> BiotacFingers::blunt_contact(std::size_t finger,
                                                             const Eigen::Matrix3d& R_world_link,
                                                             double pressure) const {
  const auto& way = ways_[finger].way();
  if (!way) return std::nullopt;
  const Eigen::Vector3d ahead = R_world_link.transpose() * *way;
  return hand::TipContact{
      .p = hand_.fingers[finger].tip.b + hand_.fingers[finger].tip.radius * ahead,
      .n = -ahead,
      .f = pressure / pressure_gain_ * ahead,
      .point_sigma = kBluntPoint,
      .normal_sigma = kBluntNormal};
}

void BiotacFingers::infer_contacts(hand::HandReading& reading) {
  const auto estimates = estimate(reading);
  const TipPoses poses = tip_poses(reading);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const BiotacEstimate& estimate = estimates[i];
    reading.contacts[i].clear();
    std::optional<hand::TipContact> contact;
    if (estimate.contact) {
      contact = in_link(*estimate.contact, static_cast<int>(i));
    } else if (estimate.pressure) {
      contact = blunt_contact(i, poses[i].linear(), *estimate.pressure);
    }
    if (contact && contact->f.dot(contact->n) < 0) reading.contacts[i].push_back(*contact);
  }
}

}  // namespace palpate::tactile
