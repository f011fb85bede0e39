// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/ros2/latest_time.hpp"
#include "palpate/ros2/robot_messages.hpp"

namespace palpate::ros2 {

/// What came, and what was wrong with it.
struct StreamCounts {
  std::uint64_t joint_states = 0, actuator_states = 0, contacts = 0, transforms = 0, wrenches = 0;
  std::uint64_t malformed = 0;     ///< could not be read, or of values that cannot be: dropped
  std::uint64_t out_of_order = 0;  ///< older than one of the same kind before it: dropped
  std::uint64_t gaps = 0;          ///< of the joint states, longer than StreamOptions::max_age
  std::uint64_t incomplete = 0;    ///< joint states without a place of the mount or all joints
  std::uint64_t restarts = 0;      ///< the clock of the joint states was set back
  std::uint64_t readings = 0;      ///< made of all that
  std::string last_error;          ///< the latest message of a malformed one
};

struct StreamOptions {
  double max_age = 0.1;  ///< s after which contacts, wrench and moving transforms no longer count

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_age", max_age, 0.01, 10.0, "s after which contacts and transforms no longer count");
  }
};

/// Makes the readings of a hand out of messages of ROS 2, as they come, in any order and from any
/// number of senders.
///
/// A reading is made of a joint state, at most one a tick (hand::kTick), of its stamp: with the
/// latest contacts of each finger, wrench and place of the mount. A stamp of zero is the time of
/// receipt; values of taxels, which have none, are as old as the latest joint state. Whatever is
/// wrong with a message is counted, and the message dropped; none throws. Where the clock of the
/// joint states is set back (LatestTime), readings begin again, with a start of their own.
class ReadingStream {
 public:
  /// @param hand  kept by reference
  /// @throws BadInput for taxels of a finger that the hand has not
  ReadingStream(const hand::Description& hand, RobotInterface interface,
                const StreamOptions& options = {});

  /// Takes a message in CDR. Topics and types that mean nothing here are ignored.
  /// @param received  ns
  /// @return a reading, where the message completes one
  std::optional<hand::HandReading> take(std::string_view topic, std::string_view type,
                                        std::string_view cdr, std::uint64_t received);

  /// Whether contacts of all fingers, wrench, torques and place of the mount have come that are not
  /// older than this, ns.
  bool has_all_since(std::uint64_t time) const;

  /// Time of the first reading since the clock was last set back, ns; HandReading::time counts from
  /// it.
  std::optional<std::uint64_t> start() const { return start_; }
  const StreamCounts& counts() const { return counts_; }

 private:
  struct Transformed {
    std::string parent;
    Eigen::Isometry3d T;
    LatestTime time;
    bool fixed = false;
  };
  struct SensedJoint {
    double angle = 0;  ///< rad
    LatestTime time;
  };
  struct TipContacts {
    std::vector<hand::TipContact> contacts;  ///< in the frame of the distal link
    LatestTime time;
  };
  std::optional<hand::HandReading> take_joints(const JointState& state, std::uint64_t received);
  void take_actuators(const JointState& state, std::uint64_t received);
  void take_contacts(std::size_t finger, const PointCloud2& cloud, std::uint64_t received);
  void take_fingertip_wrench(std::size_t finger, const WrenchStamped& wrench,
                             std::uint64_t received);
  void take_taxels(std::size_t finger, std::span<const double> values, std::uint64_t received);
  void take_wrench(const WrenchStamped& wrench, std::uint64_t received);
  void take_transforms(const TFMessage& message, bool fixed, std::uint64_t received);
  void take_transform(const TransformStamped& transform, bool fixed, std::uint64_t received);
  TimeOrder update_joints(const JointState& state, std::uint64_t time);
  void restart();
  void drop(std::string_view topic, const BadInput& error);
  std::optional<Eigen::Isometry3d> mount_at(std::uint64_t time) const;
  std::optional<hand::HandReading> reading_at(std::uint64_t time);
  bool is_later(std::uint64_t time, LatestTime& latest);
  bool is_fresh(std::uint64_t then, std::uint64_t now) const;

  const hand::Description& hand_;
  RobotInterface interface_;
  StreamOptions options_;
  std::map<std::string, std::size_t, std::less<>> finger_of_topic_, finger_of_wrench_,
      finger_of_taxels_, joint_of_, actuator_of_;
  std::map<std::string, Transformed, std::less<>> transforms_;  ///< by child
  std::vector<TipContacts> tip_contacts_;                       ///< one a finger
  std::vector<SensedJoint> joints_;
  hand::ActuatorVector torques_;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();
  std::uint64_t joints_at_ = 0;
  LatestTime torques_at_, force_at_;
  std::uint64_t next_ = 0;  ///< when the next tick begins
  std::optional<std::uint64_t> start_;
  StreamCounts counts_;
};

}  // namespace palpate::ros2
