// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/place_target.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <sstream>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::skills {
namespace {

constexpr double kNear = 0.10, kFar = 0.25;              // m, of random spots
constexpr double kSunk = 0.001;                          // m into the table that are rounding
constexpr double kAfloat = 0.003;                        // m over the table
constexpr double kMaxTilt = 3 * std::numbers::pi / 180;  // rad from a stable pose

std::vector<double> numbers_in(std::string_view text) {
  std::string spaced(text);
  for (char& c : spaced) c = c == ',' || c == '[' || c == ']' ? ' ' : c;
  std::istringstream in(spaced);
  std::vector<double> values;
  for (double value; in >> value;) values.push_back(value);
  if (!in.eof() || (values.size() != 3 && values.size() != 16)) {
    throw BadInput(
        fmt::format("'{}' is not a target: it is fixture, random, stable_pose, x,y,yaw or the 16 "
                    "numbers of a pose",
                    text));
  }
  return values;
}

void check_pose(const geometry::KnownObject& object, const Eigen::Isometry3d& T) {
  const double low = geometry::lowest_point(T, object.mesh);
  if (low < -kSunk) {
    throw BadInput(fmt::format("the target is inside the table: {} would reach {:.1f} mm into it",
                               object.name, -1e3 * low));
  }
  if (low > kAfloat) {
    throw BadInput(fmt::format("the target is in the air: {} would hang {:.1f} mm over the table",
                               object.name, 1e3 * low));
  }
  double tilt = std::numbers::pi;  // of any of its symmetric copies: a can has many
  for (const auto& S : object.symmetries) {
    tilt = std::min(tilt, nearest_stable_pose(object, T.linear() * S).tilt);
  }
  if (tilt > kMaxTilt) {
    throw BadInput(
        fmt::format("{} does not rest as the target has it: {:.1f} deg from a stable pose",
                    object.name, tilt * 180 / std::numbers::pi));
  }
}

void check_reach(const Eigen::Vector2d& xy, double reach) {
  if (xy.allFinite() && xy.norm() <= reach) return;
  throw BadInput(fmt::format(
      "the target at ({:.3f}, {:.3f}) m is out of reach: at most {:.3f} m from the origin", xy.x(),
      xy.y(), reach));
}

double tilt_between(const Eigen::Matrix3d& R_a, const Eigen::Matrix3d& R_b) {
  return std::acos(std::clamp(R_a.row(2).dot(R_b.row(2)), -1.0, 1.0));
}

/// The first of all stable poses that an estimate of an object in this one may be taken for: it is
/// right but for a symmetry, which maps stable poses beside one another where the shape keeps it
/// only roughly.
std::size_t first_of_alike(const geometry::KnownObject& object, std::size_t stable_pose) {
  std::vector<std::size_t> first(object.stable_poses.size());
  std::iota(first.begin(), first.end(), std::size_t{0});
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (const auto& S : object.symmetries) {
      const std::size_t image =
          nearest_stable_pose(object, object.stable_poses[i].R_table_object * S).stable_pose;
      const std::size_t low = std::min(first[i], first[image]);
      const std::size_t high = std::max(first[i], first[image]);
      std::ranges::replace(first, high, low);
    }
  }
  return first[stable_pose];
}

/// A pose tilted the shortest way into a stable pose, at its height over the table.
Eigen::Isometry3d laid_into(const geometry::StablePose& stable_pose, const Eigen::Isometry3d& T) {
  const Eigen::Vector3d up = T.linear() * stable_pose.R_table_object.row(2).transpose();
  Eigen::Isometry3d flat = T;
  flat.linear() = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()) * T.linear();
  flat.translation().z() = stable_pose.height;
  return flat;
}

/// Draws one of the stable poses that are not the same as the one it starts in.
std::size_t other_stable_pose(const geometry::KnownObject& object, std::size_t start,
                              RandomStream& random) {
  std::vector<double> weights;
  double sum = 0;
  for (const auto& stable_pose : object.stable_poses) {
    const bool same = same_side_up(object, stable_pose.R_table_object,
                                   object.stable_poses[start].R_table_object, kMaxTilt);
    weights.push_back(same ? 0 : stable_pose.probability);
    sum += weights.back();
  }
  if (sum <= 0) throw BadInput(fmt::format("{} has no other stable pose", object.name));
  double share = sum * random.uniform();
  std::size_t drawn = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] <= 0) continue;
    drawn = i;
    share -= weights[i];
    if (share < 0) break;
  }
  return drawn;
}

PlaceTarget random_spot(double reach, std::uint64_t seed) {
  RandomStream random(seed, "place");
  const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
  const double radius = random.uniform(kNear, std::clamp(reach, kNear, kFar));
  PlaceTarget target;
  target.xy = radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  target.yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
  return target;
}

PlaceTarget target_of(std::string_view text, const geometry::KnownObject& object,
                      const FixtureOptions& fixture, double reach, std::uint64_t seed) {
  PlaceTarget target;
  if (text == "random") return random_spot(reach, seed);
  if (text == "fixture") {
    make_fixture(object, fixture);  // throws if it does not fit
    target.kind = PlaceTarget::Kind::fixture;
    target.T_world_object = resting_pose(object, static_cast<std::size_t>(fixture.stable_pose),
                                         {fixture.x, fixture.y}, fixture.yaw);
    return target;
  }
  const std::vector<double> values = numbers_in(text);
  if (values.size() == 3) {
    target.xy << values[0], values[1];
    target.yaw = values[2];
    return target;
  }
  std::array<double, 16> pose{};
  std::copy(values.begin(), values.end(), pose.begin());
  target.kind = PlaceTarget::Kind::pose;
  target.T_world_object = pose_from_row_major(pose);
  check_pose(object, target.T_world_object);
  return target;
}

}  // namespace

PlaceTarget parse_target(std::string_view text, const geometry::KnownObject& object,
                         const FixtureOptions& fixture, double reach, std::uint64_t seed) {
  const PlaceTarget target = target_of(text, object, fixture, reach, seed);
  const bool spot = target.kind == PlaceTarget::Kind::spot;
  check_reach(spot ? target.xy : target.T_world_object.translation().head<2>(), reach);
  return target;
}

bool same_side_up(const geometry::KnownObject& object, const Eigen::Matrix3d& R_a,
                  const Eigen::Matrix3d& R_b, double most) {
  return std::any_of(object.symmetries.begin(), object.symmetries.end(),
                     [&](const Eigen::Matrix3d& S) { return tilt_between(R_a * S, R_b) < most; });
}

PlaceTarget stable_pose_target(const geometry::KnownObject& object, std::size_t start_stable_pose,
                               int wanted, double reach, std::uint64_t seed) {
  const int count = static_cast<int>(object.stable_poses.size());
  if (wanted < -1 || wanted >= count) {
    throw BadInput(fmt::format("place.stable_pose = {}: {} has the stable poses 0..{}", wanted,
                               object.name, count - 1));
  }
  if (start_stable_pose >= object.stable_poses.size()) {
    throw BadInput(
        fmt::format("an object that starts in stable pose {}: {} has the stable poses 0..{}",
                    start_stable_pose, object.name, count - 1));
  }
  RandomStream random(seed, "place stable pose");
  const std::size_t stable_pose = wanted >= 0
                                      ? static_cast<std::size_t>(wanted)
                                      : other_stable_pose(object, start_stable_pose, random);
  const PlaceTarget spot = random_spot(reach, seed);
  check_reach(spot.xy, reach);
  PlaceTarget target;
  target.kind = PlaceTarget::Kind::pose;
  target.T_world_object = resting_pose(object, stable_pose, spot.xy, spot.yaw);
  return target;
}

NearestStablePose nearest_stable_pose(const geometry::KnownObject& object,
                                      const Eigen::Matrix3d& R_world_object) {
  const Eigen::Vector3d up = R_world_object.row(2);
  NearestStablePose nearest{0, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < object.stable_poses.size(); ++i) {
    const double along = object.stable_poses[i].R_table_object.row(2).dot(up);
    const double tilt = std::acos(std::clamp(along, -1.0, 1.0));
    if (tilt < nearest.tilt) nearest = {i, tilt};
  }
  return nearest;
}

Eigen::Isometry3d laid_flat(const geometry::KnownObject& object,
                            const Eigen::Isometry3d& T_world_object) {
  const std::size_t stable_pose = nearest_stable_pose(object, T_world_object.linear()).stable_pose;
  return laid_into(object.stable_poses[stable_pose], T_world_object);
}

Eigen::Isometry3d target_pose(const PlaceTarget& target, const geometry::KnownObject& object,
                              std::size_t found_stable_pose) {
  if (target.kind != PlaceTarget::Kind::spot) return target.T_world_object;
  const geometry::StablePose& found = object.stable_poses[found_stable_pose];
  Eigen::Isometry3d T =
      resting_pose(object, first_of_alike(object, found_stable_pose), target.xy, target.yaw);
  const auto tilt = [&](const Eigen::Matrix3d& S) {
    return tilt_between(T.linear() * S, found.R_table_object);
  };
  T.linear() *= *std::ranges::min_element(object.symmetries, {}, tilt);
  return laid_into(found, T);
}

}  // namespace palpate::skills
