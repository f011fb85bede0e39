// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/hand/hand.hpp"
#include "palpate/planning/collision_checker.hpp"

namespace palpate::planning {

/// Columns of a file's mount, before the joints; m and rad.
inline constexpr std::array<std::string_view, 6> kMountNames = {"x",   "y",     "z",
                                                                "yaw", "pitch", "roll"};

/// A row q of the waypoints Q (thesis eq. 2.1): all joint angles, and where the mount is.
struct Waypoint {
  hand::MountPosition mount;
  hand::JointVector joints;  ///< rad
};

/// What the controllers are commanded to get there: J0 = J1 + J2, shared as in free flexion.
hand::HandCommand command_of(const Waypoint& waypoint, const hand::Description& hand);

struct WaypointsFile {
  std::vector<Waypoint> waypoints;
  bool has_mount = false;  ///< else every mount is the given one
};

/// Waypoints from a CSV: a header with the names of all joints of the hand, in any order, and
/// either all or none of kMountNames; one row a waypoint. Values need only be finite. A first
/// column t_s, as planned paths have it, is left out.
/// @param source  named in errors, as in "waypoints.csv:3: ..."
/// @param mount  where there is none in the file
/// @throws BadInput for a header of the wrong width or names, a row of the wrong width, a value
///         that is no finite number, fewer than two rows
WaypointsFile parse_waypoints(std::string_view text, std::string_view source,
                              const hand::MountPosition& mount, const hand::Description& hand);

/// A waypoint that the hand cannot take, and why, in one line.
struct InvalidWaypoint {
  std::size_t waypoint = 0;  ///< index
  std::string reason;        ///< the joint and its value, or the pair of bodies and its depth
};

/// How far the mount reaches.
struct MountRange {
  double side = 1.0;     ///< m, of |x| and |y|
  double low = 0.0;      ///< m, of z
  double high = 1.0;     ///< m, of z
  double turn = 6.2832;  ///< rad, of |yaw|, |pitch| and |roll|

  template <class Visitor>
  void visit(Visitor&& v) {
    v("side", side, 0.0, 10.0, "m, largest |x| and |y| of the mount");
    v("low", low, -10.0, 10.0, "m, least z of the mount");
    v("high", high, -10.0, 10.0, "m, largest z of the mount");
    v("turn", turn, 0.0, 100.0, "rad, largest |yaw|, |pitch| and |roll| of the mount");
  }
};

/// Every waypoint with an angle that is not finite, beyond its joint's range, or where a coupled
/// pair cannot be; with a mount out of its range; or, where all that is well, in collision. In
/// order.
std::vector<InvalidWaypoint> find_invalid_waypoints(const std::vector<Waypoint>& waypoints,
                                                    CollisionChecker& scene,
                                                    const MountRange& range = {});

}  // namespace palpate::planning
