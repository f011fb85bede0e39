// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/finger_sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/geometry/query/rounded_hull.hpp"

namespace palpate::tactile {
namespace {

constexpr std::array<std::string_view, kSampleFlags> kFlagNames = {
    "gap",      "late",       "repeated",   "out_of_order", "placeholder",
    "no_force", "not_finite", "no_contact", "far_apart",    "left_out"};
constexpr unsigned kUsable = static_cast<unsigned>(SampleFlag::gap) |
                             static_cast<unsigned>(SampleFlag::late) |
                             static_cast<unsigned>(SampleFlag::left_out);
constexpr double kOffGrid = 0.25;     // of a period
constexpr int kFramesOfNewClock = 5;  // in order before the last time that show it to be wrong
constexpr double kNextOfThem = 2.5;   // periods from each of them to the next

const Eigen::Vector3d kPlaceholder(0, -1, 0);

bool finite(const FingerContact& contact) {
  return contact.p.allFinite() && contact.f.allFinite() &&
         (!contact.tip_normal || contact.tip_normal->allFinite());
}

bool same(const FingerContact& a, const FingerContact& b) { return a.p == b.p && a.f == b.f; }

bool same_contacts(const FingerFrame& a, const FingerFrame& b) {
  return !a.contacts.empty() && a.contacts.size() == b.contacts.size() &&
         std::equal(a.contacts.begin(), a.contacts.end(), b.contacts.begin(), same);
}

/// Whether a frame holds what the last one held. A finger that presses nothing may: it is no stuck
/// sensor.
bool repeats(const FingerFrame& frame, const FingerFrame& last, double min_force) {
  const auto presses = [&](const FingerContact& c) { return c.f.norm() >= min_force; };
  return same_contacts(frame, last) && std::ranges::any_of(frame.contacts, presses);
}

/// The contacts that have information; flags those that do not.
std::vector<FingerContact> sound_contacts(const FingerFrame& frame, double min_force,
                                          SampleFlags& flags) {
  if (frame.contacts.empty()) flags.set(SampleFlag::no_contact);
  SampleFlags faults;
  std::vector<FingerContact> sound;
  for (const FingerContact& contact : frame.contacts) {
    if (!finite(contact)) {
      faults.set(SampleFlag::not_finite);
    } else if (contact.f == kPlaceholder) {
      faults.set(SampleFlag::placeholder);
    } else if (contact.f.norm() < min_force) {
      faults.set(SampleFlag::no_force);
    } else {
      sound.push_back(contact);
    }
  }
  if (sound.empty()) {
    flags.merge(faults);
  } else if (faults.any()) {
    flags.set(SampleFlag::left_out);
  }
  return sound;
}

bool are_one(const FingerContact& a, const FingerContact& b, const SampleOptions& options) {
  if ((a.p - b.p).norm() > options.one_contact) return false;
  if (!a.tip_normal || !b.tip_normal) return true;
  return a.tip_normal->dot(*b.tip_normal) >= std::cos(options.one_direction);
}

bool are_one(const std::vector<FingerContact>& contacts, const SampleOptions& options) {
  for (const auto& a : contacts) {
    for (const auto& b : contacts) {
      if (!are_one(a, b, options)) return false;
    }
  }
  return true;
}

void merge(const std::vector<FingerContact>& contacts, FingerSample& sample) {
  const auto count = static_cast<double>(contacts.size());
  sample.p.setZero();
  sample.f.setZero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (const FingerContact& contact : contacts) {
    sample.p += contact.p / count;
    sample.f += contact.f;
    if (contact.tip_normal) normal += *contact.tip_normal;
  }
  if (normal.norm() > 0.1 * count) sample.tip_normal = normal.normalized();
}

/// The point of a fingertip's axis or core that is nearest to a point.
class NearestInCore {
 public:
  explicit NearestInCore(const hand::Finger& finger) : tip_(finger.tip) {
    if (finger.hull) hull_.emplace(finger.hull->core, finger.hull->radius);
  }

  double radius() const { return hull_ ? hull_->radius() : tip_.radius; }

  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const {
    if (hull_) return hull_->nearest_in_core(p);
    const Eigen::Vector3d axis = tip_.b - tip_.a;
    const double along = axis.dot(p - tip_.a) / axis.squaredNorm();
    return tip_.a + std::clamp(along, 0.0, 1.0) * axis;
  }

 private:
  hand::TipCapsule tip_;
  std::optional<geometry::RoundedHull> hull_;
};

}  // namespace

std::string_view to_string(SampleFlag flag) {
  for (std::size_t i = 0; i < kFlagNames.size(); ++i) {
    if (static_cast<unsigned>(flag) == 1u << i) return kFlagNames[i];
  }
  return "unknown";
}

bool SampleFlags::usable() const { return (bits_ & ~kUsable) == 0; }

std::string SampleFlags::names() const {
  std::string result;
  for (std::size_t i = 0; i < kFlagNames.size(); ++i) {
    if ((bits_ & 1u << i) == 0) continue;
    if (!result.empty()) result += '+';
    result += kFlagNames[i];
  }
  return result;
}

SampleMaker::SampleMaker(const SampleOptions& options) : options_(options) {
  if (!(std::isfinite(options.period) && options.period > 0)) {
    throw BadInput(fmt::format("the period must be positive, not {} s", options.period));
  }
  if (!(options.min_force >= 0 && options.one_contact >= 0 && options.one_direction >= 0)) {
    throw BadInput(
        fmt::format("least_force {} N, one_contact {} m and one_direction {} rad must not be "
                    "negative",
                    options.min_force, options.one_contact, options.one_direction));
  }
}

bool SampleMaker::is_of_new_clock(double time) {
  const double step = time - early_time_;
  const bool follows = early_frames_ > 0 && step > 0 && step < kNextOfThem * options_.period;
  early_frames_ = follows ? early_frames_ + 1 : 1;
  early_time_ = time;
  return early_frames_ >= kFramesOfNewClock;
}

void SampleMaker::check_time(const FingerFrame& frame, SampleFlags& flags) {
  if (!std::isfinite(frame.time)) {
    flags.set(SampleFlag::not_finite);
  } else if (last_ && frame.time < last_->time) {
    flags.set(is_of_new_clock(frame.time) ? SampleFlag::gap : SampleFlag::out_of_order);
    return;
  } else if (last_ && (frame.time == last_->time || repeats(frame, *last_, options_.min_force))) {
    flags.set(SampleFlag::repeated);
  } else if (last_) {
    const double periods = (frame.time - last_->time) / options_.period;
    if (std::abs(periods - std::round(periods)) > kOffGrid) flags.set(SampleFlag::late);
    if (periods > 1.5) flags.set(SampleFlag::gap);
  }
  early_frames_ = 0;
}

FingerSample SampleMaker::next(const FingerFrame& frame) {
  FingerSample sample{.time = frame.time,
                      .p = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                      .f = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                      .tip_normal = {},
                      .flags = {}};
  check_time(frame, sample.flags);
  if (sample.flags.usable() || sample.flags.has(SampleFlag::repeated)) last_ = frame;
  if (!sample.flags.usable()) return sample;
  const auto contacts = sound_contacts(frame, options_.min_force, sample.flags);
  if (!are_one(contacts, options_)) sample.flags.set(SampleFlag::far_apart);
  if (sample.flags.usable()) merge(contacts, sample);
  if (sample.flags.usable() && sample.f.norm() < options_.min_force) {
    sample.flags.set(SampleFlag::no_force);  // contacts that push against each other
  }
  return sample;
}

FingerFrame finger_frame(const hand::HandReading& reading, const hand::Description& hand,
                         int finger) {
  const auto i = static_cast<std::size_t>(finger);
  FingerFrame frame{.time = reading.time, .contacts = {}};
  if (reading.contacts.at(i).empty()) return frame;
  const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
  const Eigen::Isometry3d T =
      reading.mount.pose() * T_mount_link.at(static_cast<std::size_t>(hand.fingers[i].link));
  const NearestInCore nearest_in_core(hand.fingers[i]);
  for (const hand::TipContact& contact : reading.contacts[i]) {
    const Eigen::Vector3d inward = nearest_in_core(contact.p) - contact.p;
    FingerContact sensed{.p = T * contact.p, .f = T.linear() * contact.f, .tip_normal = {}};
    if (inward.norm() > 0.1 * nearest_in_core.radius()) {
      sensed.tip_normal = T.linear() * inward.normalized();
    }
    frame.contacts.push_back(sensed);
  }
  return frame;
}

}  // namespace palpate::tactile
