// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/calibrate_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/tactile/calibration/link_calibration.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"
#include "skills/explore/calibration_touches.hpp"
#include "skills/explore/table_press.hpp"
#include "skills/load_calibration.hpp"
#include "skills/motion/lowest_part.hpp"
#include "skills/motion/motion_constants.hpp"

namespace palpate::skills {
namespace {

constexpr double kFirstReach = 0.035;   // m over and under the table that nobody has measured
constexpr double kSearchReach = 0.014;  // m over and under where the last touch found it
constexpr double kSettling = 0.1;       // s
constexpr double kLongSettling = 1.0;   // s, of fingers that still swing
constexpr double kSwing = 0.1;          // rad from their commands
constexpr int kSettledTicks = 20;       // in a row near their commands
constexpr int kMissedTouches = 3;       // in a row, after which the table is looked for again
constexpr double kLastingShare = 0.8;   // of the readings in which a resting fingertip touches
constexpr double kSecondsATouch = 8;    // amply
constexpr int kLoadAttitudes = 10;      // in which the load of the hand alone is read
constexpr int kInsensitiveTouches = 3;  // in a row that a tip must miss to be believed no more
constexpr int kLoadTouches = 3;         // after which the sign of the mount's load is judged
constexpr double kLeastPress = 0.15;    // N, rms, of fingertips that it is judged by
constexpr double kReversed = 0.5;       // of their press, by which the load rises then
constexpr double kContradiction = 3.0;  // sigmas, rms, that touches leave unexplained

/// Lets the fingertip rest where it touches, no longer pushed on.
void rest(Executor& robot, const CalibrateOptions& options) {
  hand::MountPosition here = robot.command().mount;
  here.xyz += kLeadTakenBack * (robot.reading().mount.xyz - here.xyz);  // it would push on
  robot.move_mount(here, options.speed);
  robot.wait(kSettling + options.rest);
  robot.add_event(estimation::TouchEvent::on_table);
}

/// The weaker the drives and the heavier the fingers, the longer these swing when the mount stops.
void wait_for_swinging_fingers(Executor& robot) {
  const auto near = [&](const hand::HandReading& reading) {
    const hand::ActuatorVector positions = hand::actuator_positions(robot.model(), reading.joints);
    return (robot.command().positions - positions).cwiseAbs().maxCoeff() < kSwing;
  };
  if (near(robot.reading())) return;
  robot.wait(kLongSettling, [&, ticks = 0](const hand::HandReading& reading) mutable {
    ticks = near(reading) ? ticks + 1 : 0;
    return ticks >= kSettledTicks;
  });
}

/// How the mount's load answers what fingertips press on the table with: it falls by as much. Where
/// it rises, it is read with the wrong sign, and no touch would stop the mount.
class LoadDirection {
 public:
  /// @param free  load of the mount before the touch, upwards, N
  /// @param log  that ends with the finger at rest on the table, for some seconds
  void add(double free, const estimation::EventLog& log, int finger, double seconds) {
    const std::span<const hand::HandReading> readings(log.readings);
    const auto rest = static_cast<std::size_t>(hand::whole_ticks(seconds));
    const auto count = std::min(readings.size(), rest);
    double rise = -free, press = 0;
    for (const auto& reading : readings.last(count)) {
      rise += reading.mount_force.z() / static_cast<double>(count);
      press += hand::tip_force(reading, finger) / static_cast<double>(count);
    }
    ++touches_;
    rises_ += rise * press;
    presses_ += press * press;
  }
  [[nodiscard]] bool reversed() const {
    return touches_ >= kLoadTouches && presses_ > kLoadTouches * kLeastPress * kLeastPress &&
           rises_ > kReversed * presses_;
  }
  /// N by which the load rises for 1 N of press.
  [[nodiscard]] double slope() const { return rises_ / presses_; }

 private:
  int touches_ = 0;
  double rises_ = 0, presses_ = 0;  // N^2
};

/// Why a fingertip that presses on the table does not count as sensing it.
std::string_view why_insensitive(const Executor& robot, std::size_t finger) {
  const auto& contacts = robot.reading().contacts[finger];
  const bool inward = std::ranges::any_of(contacts, [](const auto& contact) {
    return contact.f.dot(contact.n) > 0.5 * contact.f.norm();
  });
  return inward ? ": f.n > 0, so the force of the finger on the object, or the outward normal of "
                  "the object, has the wrong sign"
                : "";
}

/// The estimates from the touches so far of the table and of the sensor of the mount's load.
struct TableSearch {
  UnsensedPresses unsensed;
  std::optional<double> height;  ///< where the last touch found the table, m
  int missed = 0;                ///< touches in a row that found nothing there
  LoadCalibration load;
  LoadDirection direction;
  int next_load = 0;  ///< attitudes till the load is read again
};

/// @throws SafetyStop for a load that is read with the wrong sign
void require_right_load(Executor& robot, const LoadDirection& direction) {
  if (!direction.reversed()) return;
  robot.stop_for(
      Fault::out_of_range,
      fmt::format("the mount's load rises by {:.1f} N for 1 N with which a fingertip "
                  "presses on the table: mount_force has the wrong sign, it is the force "
                  "of the arm on the hand",
                  direction.slope()));
}

void distrust_insensitive(Executor& robot, int finger) {
  const auto i = static_cast<std::size_t>(finger);
  robot.distrust(finger, fmt::format("{} does not sense the table{}", robot.model().fingers[i].name,
                                     why_insensitive(robot, i)));
}

/// A fingertip that does not sense the table is believed no more, unless another one reports what
/// it touches: the two may be swapped, which the other's touches tell.
void judge_press(Executor& robot, int finger, const TablePress& press, UnsensedPresses& unsensed) {
  unsensed.add(finger, press);
  if (unsensed.count(finger) < kInsensitiveTouches) return;
  if (!unsensed.reporter(finger)) {
    distrust_insensitive(robot, finger);
  } else if (const auto other = unsensed.swapped_with(finger, kInsensitiveTouches)) {
    robot.swap_touch(finger, *other);
    unsensed.forget(finger);
    unsensed.forget(*other);
  }
}

void touch_table(Executor& robot, const CalibrationTouch& touch, const CalibrateOptions& options,
                 TableSearch& search) {
  take_attitude(robot, touch, options);
  const double reach = search.height ? kSearchReach : kFirstReach;
  const double contact_height = search.height.value_or(0) - lowest(robot.model(), touch);
  robot.move_mount(touch.mount(options, contact_height + reach), options.travel_speed);
  std::optional<double> free;  // N, upwards, in the air
  if (search.next_load-- == 0) {
    const Eigen::Vector3d load = steady_load(robot);
    search.load.add(robot.command().mount, load);
    free = load.z();
    search.next_load = options.touches / kLoadAttitudes;
  } else {
    robot.wait(kSettling);
  }
  wait_for_swinging_fingers(robot);
  const TablePress press = press_table(robot, touch, options, contact_height - reach);
  search.missed = press.met ? 0 : search.missed + 1;
  if (search.missed >= kMissedTouches) search.height.reset();
  if (press.met) judge_press(robot, touch.finger, press, search.unsensed);
  if (press.sensed_by(touch.finger)) {
    search.height = lowest(robot.model(), touch) + robot.reading().mount.xyz.z();
    rest(robot, options);
    if (free) search.direction.add(*free, robot.log(), touch.finger, options.rest);
    require_right_load(robot, search.direction);
  }
  rise(robot, kTravelHeight, options.travel_speed);
}

/// What a fingertip senses through a window of readings, in the distal link's frame.
struct SensedContacts {
  int readings = 0, contacts = 0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  ///< mean of the contacts
  double reported_variance = 0;                 ///< of them, as the sensor reports
  double mean_variance = 0;                     ///< of p, an axis, by how much they scatter
};

SensedContacts sensed_contacts(std::span<const hand::HandReading> window, std::size_t finger) {
  SensedContacts sensed;
  for (const auto& reading : window) {
    sensed.readings += !reading.contacts[finger].empty();
    for (const auto& contact : reading.contacts[finger]) {
      ++sensed.contacts;
      sensed.p += contact.p;
      sensed.reported_variance += contact.point_sigma * contact.point_sigma;
    }
  }
  sensed.p /= std::max(1, sensed.contacts);
  sensed.reported_variance /= std::max(1, sensed.contacts);
  for (const auto& reading : window) {
    for (const auto& contact : reading.contacts[finger]) {
      sensed.mean_variance += (contact.p - sensed.p).squaredNorm() / 3;
    }
  }
  sensed.mean_variance /= std::max(1.0, std::pow(sensed.contacts, 2));
  return sensed;
}

/// The fingertips that rest on the table through a window of readings.
void add_resting_tips(std::span<const hand::HandReading> window, double sigma,
                      std::vector<tactile::TipOnPlane>& touches) {
  const hand::JointVector joints = tactile::mean_joints(window);
  for (std::size_t finger = 0; finger < window.back().contacts.size(); ++finger) {
    const SensedContacts sensed = sensed_contacts(window, finger);
    if (sensed.readings < kLastingShare * static_cast<double>(window.size())) continue;
    touches.push_back(
        {{static_cast<int>(finger), joints},
         sensed.p,
         estimation::mean_mount(window).pose().inverse(),
         std::sqrt(std::max(sigma * sigma, sensed.mean_variance) + sensed.reported_variance)});
  }
}

std::vector<tactile::TipOnPlane> table_touches(const estimation::EventLog& log,
                                               const CalibrateOptions& options) {
  const auto readings = static_cast<std::size_t>(std::lround(options.rest / hand::kTick));
  std::vector<tactile::TipOnPlane> touches;
  for (const auto& moment : log.moments) {
    if (moment.event != estimation::TouchEvent::on_table) continue;
    const std::size_t count = std::min(readings, moment.reading + 1);
    add_resting_tips(std::span(log.readings).subspan(moment.reading + 1 - count, count),
                     options.sigma, touches);
  }
  return touches;
}

/// Root mean square of what the calibration leaves unexplained, in standard deviations.
double unexplained(const tactile::HandCalibration& found,
                   const std::vector<tactile::TipOnPlane>& touches) {
  double sum = 0;
  for (tactile::TipOnPlane touch : touches) {
    touch.T_mount_plane = touch.T_mount_plane * found.T_believed_plane;
    sum += std::pow(tactile::distance_from_plane(found.hand, touch) / touch.sigma, 2);
  }
  return touches.empty() ? 0 : std::sqrt(sum / static_cast<double>(touches.size()));
}

}  // namespace

tactile::HandCalibration calibration(const hand::Description& hand, const estimation::EventLog& log,
                                     const CalibrateOptions& options) {
  const auto touches = table_touches(log, options);
  tactile::HandCalibration found =
      tactile::calibrate_links(hand, touches, fingertips_in_grasps(hand), mount_prior(options));
  if (unexplained(found, touches) < kContradiction) return found;
  return {hand};
}

hand::Description calibrated_hand(const hand::Description& hand, estimation::EventLog& log,
                                  const CalibrateOptions& options) {
  tactile::HandCalibration found = calibration(hand, log, options);
  log.T_world_table = Eigen::Isometry3d(found.T_believed_plane.linear());
  return std::move(found.hand);
}

double CalibratePhase::time_limit() const { return 20 + kSecondsATouch * options_.touches; }

PhaseEnd CalibratePhase::run(Executor& robot, PickState& state) {
  const hand::Description before = robot.model();
  TableSearch search;
  for (const auto& touch : calibration_touches(before, options_)) {
    if (!is_reachable(robot, touch, options_) || !robot.trust().trusted(touch.finger)) continue;
    try {
      touch_table(robot, touch, options_, search);
    } catch (const Unreachable&) {  // NOLINT(bugprone-empty-catch): the next one begins by rising
    }
  }
  for (int finger = 0; finger < before.finger_count(); ++finger) {
    if (search.unsensed.count(finger) >= kInsensitiveTouches) distrust_insensitive(robot, finger);
  }
  const hand::HandCommand& now = robot.command();
  const double free =
      std::max(kFreeHeight, state.clear_height -
                                lowest_part(robot.model(), now.positions, attitude_of(now.mount)));
  rise(robot, std::max(0.0, free - now.mount.xyz.z()), options_.travel_speed);
  const auto touches = table_touches(robot.log(), options_);
  const tactile::HandCalibration found = calibration(before, robot.log(), options_);
  robot.set_model(found.hand);
  robot.set_table(found.T_believed_plane);
  robot.load_sensor().set_error(search.load.error());
  const bool better = robot.model().kinematic_error < before.kinematic_error;
  return {better, fmt::format("{} touches of the table, kinematic error {:.2f} mm", touches.size(),
                              1e3 * robot.model().kinematic_error)};
}

}  // namespace palpate::skills
