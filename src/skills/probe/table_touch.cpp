// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/table_touch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/se3.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "palpate/skills/stop_conditions.hpp"

namespace palpate::skills {
namespace {

constexpr localization::PoseTolerance kTight{2.5 * kDegree, 0.0035};
constexpr int kDraws = 150;  // poses of the posterior by which turns are compared
constexpr int kAzimuths = 8;
constexpr std::array<double, 2> kTurns = {0.3, 0.55};  // rad
constexpr double kHandOver = 0.005;       // m of the hand over the object's lowest point
constexpr double kClearShare = 0.9;       // of the poses, by which it is
constexpr double kMetSigma = 0.0012;      // m, of the height at which the table is met
constexpr double kUnlike = 1e-6;          // likelihood that a pose keeps
constexpr double kTableTouchSeconds = 4;  // s that a touch takes
constexpr double kSlowFrom = 0.006;       // m over the expected touch, and two of its sigmas
constexpr double kGiveUp = 0.012;         // m below it, and two of its sigmas
constexpr double kTurnedSpeed = 0.15;     // m/s
constexpr double kDownSpeed = 0.1;        // m/s
constexpr double kClearance = 0.02;       // m of the object over the table while it turns
constexpr double kGuardedSpeed = 0.005;  // m/s: the stiff grip presses 2 N/mm, and turns the object
constexpr double kBorne = 0.25;          // N that the table bears
constexpr double kKnocked = 1.5;         // N by which a fast motion has met something
constexpr double kSetOutSeconds = 0.15;  // s of a motion in which the load is that of setting out

double lowest_point(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object) {
  const Eigen::RowVector3f up = T_world_object.linear().row(2).cast<float>();
  float low = std::numeric_limits<float>::infinity();
  for (const Eigen::Vector3f& corner : object.hull()) low = std::min(low, up.dot(corner));
  return T_world_object.translation().z() + static_cast<double>(low);
}

/// The rigid motion that turns about a point.
Eigen::Isometry3d turned_about(const Eigen::Vector3d& point, const Eigen::Vector3d& turn) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = exp_so3(turn);
  T.translation() = point - T.linear() * point;
  return T;
}

std::vector<Eigen::Vector3d> possible_turns() {
  std::vector<Eigen::Vector3d> turns;
  for (const double angle : kTurns) {
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / kAzimuths;
      turns.emplace_back(angle * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
    }
  }
  return turns;
}

hand::MountPosition lowered(hand::MountPosition mount, double by) {
  mount.xyz.z() -= by;
  return mount;
}

}  // namespace

TableTouchChoice::TableTouchChoice(const Executor& robot, const geometry::ObjectModel& object,
                                   const localization::Posterior& held, RandomStream random)
    : object_(object),
      mount_(robot.reading().mount.pose()),
      in_modes_(1 - held.residual_mass()),
      best_(held.modes.front().T_frame_object),
      centroid_(best_ * object.object().mass_properties.centroid),
      poses_(localization::draw_poses(held, kDraws, random)),
      weights_(poses_.size(), 1.0 / static_cast<double>(poses_.size())) {
  const auto T_mount_link = hand::forward_kinematics(robot.model(), robot.reading().joints);
  for (const hand::LinkSphere& ball : robot.model().spheres) {
    const auto& T = T_mount_link[static_cast<std::size_t>(ball.link)];
    hand_.emplace_back(mount_ * (T * ball.center), ball.radius);
  }
}

Eigen::Isometry3d TableTouchChoice::turned_mount(const TableTouch& touch) const {
  return turned_about(centroid_, touch.turn) * mount_;
}

/// Over the centroid, one a drawn pose.
std::vector<double> TableTouchChoice::lowest_points(const Eigen::Vector3d& turn) const {
  const Eigen::Isometry3d T = turned_about(centroid_, turn);
  std::vector<double> lowest;
  for (const auto& pose : poses_) {
    lowest.push_back(lowest_point(object_, T * pose) - centroid_.z());
  }
  return lowest;
}

double TableTouchChoice::lowest_of_hand(const Eigen::Vector3d& turn) const {
  const Eigen::Isometry3d T = turned_about(centroid_, turn);
  double low = std::numeric_limits<double>::infinity();
  for (const auto& [center, radius] : hand_) low = std::min(low, (T * center).z() - radius);
  return low - centroid_.z();
}

std::optional<TableTouch> TableTouchChoice::judged(const Eigen::Vector3d& turn) const {
  const double room = lowest_of_hand(turn) - kHandOver;
  const std::vector<double> lowest = lowest_points(turn);
  double clear = 0, mean = 0, square = 0;
  std::vector<localization::PredictedTouches> outcomes;
  for (std::size_t i = 0; i < lowest.size(); ++i) {
    clear += lowest[i] < room ? weights_[i] : 0;
    mean += weights_[i] * lowest[i];
    square += weights_[i] * lowest[i] * lowest[i];
    outcomes.push_back({{true, lowest[i], Eigen::Vector3d::Zero()}});
  }
  if (clear < kClearShare) return std::nullopt;
  localization::NextTouchOptions options;
  options.point_sigma = kMetSigma;
  const double information = localization::information_bound(outcomes, weights_, options);
  return TableTouch{turn,
                    mean,
                    std::sqrt(std::max(0.0, square - mean * mean)),
                    {information, kTableTouchSeconds}};
}

double TableTouchChoice::travel_height() const {
  double low = std::ranges::min(lowest_points(Eigen::Vector3d::Zero()));
  for (const Eigen::Vector3d& turn : possible_turns()) {
    low = std::min(low, std::ranges::min(lowest_points(turn)));
  }
  return std::min(height(), kClearance - low);
}

std::optional<TableTouch> TableTouchChoice::next() const {
  std::optional<TableTouch> best;
  for (const Eigen::Vector3d& turn : possible_turns()) {
    if (std::find(done_.begin(), done_.end(), turn) != done_.end()) continue;
    const auto touch = judged(turn);
    if (!touch || (best && touch->expected_gain.rate() <= best->expected_gain.rate())) continue;
    best = touch;
  }
  return best;
}

double TableTouchChoice::tight_share() const {
  double share = 0;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const auto error = localization::pose_error(poses_[i], best_, object_.object().symmetries);
    share += localization::within(error, kTight) ? weights_[i] : 0;
  }
  return std::min(1.0, share) * std::min(1.0, in_modes_);
}

void TableTouchChoice::made(const TableTouch& touch, std::optional<double> lowest) {
  done_.push_back(touch.turn);
  if (!lowest) return;
  const std::vector<double> expected = lowest_points(touch.turn);
  double total = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double r = (expected[i] - *lowest) / kMetSigma;
    weights_[i] *= std::exp(-r * r / 2) + kUnlike;
    total += weights_[i];
  }
  for (double& weight : weights_) weight /= total;
}

std::optional<double> touch_table(Executor& robot, const TableTouchChoice& choice,
                                  const TableTouch& touch, double min_load) {
  const hand::MountPosition high =
      hand::nearest_mount(choice.turned_mount(touch), robot.command().mount);
  const hand::MountPosition turned = lowered(high, choice.height() - choice.travel_height());
  const double way = choice.height() + touch.lowest;  // down to the table
  const hand::MountPosition over = lowered(high, way - kSlowFrom - 2 * touch.sigma);
  const hand::MountPosition low = lowered(high, way + kGiveUp + 2 * touch.sigma);
  for (const auto& place : {turned, low}) {
    if (!robot.obstacle(place).empty()) return std::nullopt;
  }
  robot.move_mount(turned, kTurnedSpeed);
  robot.wait(kSettleSeconds);
  const double load = estimation::mean_load(robot.log());
  if (load < min_load) return std::nullopt;
  const auto stopped = [&](const hand::MountPosition& to, double speed, double borne) {
    return robot.move_mount(to, speed, load_below(load - borne, robot.time() + kSetOutSeconds)) ==
           MotionEnd::stopped;
  };
  const bool met = stopped(over, kDownSpeed, kKnocked) || stopped(low, kGuardedSpeed, kBorne);
  std::optional<double> lowest;
  if (met) {
    robot.add_event(estimation::TouchEvent::table_touched);
    const double down =
        choice.turned_mount(touch).translation().z() - robot.reading().mount.xyz.z();
    lowest = down - choice.height();
  }
  robot.move_mount(turned, kTurnedSpeed);
  return lowest;
}

}  // namespace palpate::skills
