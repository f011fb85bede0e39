// SPDX-License-Identifier: Apache-2.0
#include "localization/search/modes.hpp"

#include <algorithm>
#include <numbers>

#include "localization/search/free_axis_fit.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr std::size_t kCandidates = 100;  // centres tried for a ball
/// Of the poses. Once so many are in modes, the rest is only listed where it lies together.
constexpr double kEnoughHeld = 0.97, kWorthListing = 0.004;
/// Of the poses about which a mode is centred: most of a ball.
constexpr PoseTolerance kCore{3.5 * std::numbers::pi / 180, 0.007};
constexpr int kCoreSteps = 4;       // of shifting a centre to the mean of the poses about it
constexpr double kCoreShare = 0.9;  // of the poses in the ball that must be about its core, too
constexpr double kMinCount = 0.5;   // of poses like one that is reported, at least
constexpr double kAxisGain = 1.5;   // times a ball's poses that a free axis must hold

using Poses = std::vector<PosePoint>;

struct Cluster {
  PoseFamily family;
  Poses members;
};

Poses members_of(const PoseFamily& family, const Poses& poses,
                 const PoseFamily::Symmetries& symmetries, const PoseTolerance& tolerance = {}) {
  Poses result;
  for (const PosePoint& pose : poses) {
    if (family.contains(pose, symmetries, tolerance)) result.push_back(pose);
  }
  return result;
}

/// The members' mean, each in the symmetric copy nearest to the centre.
PosePoint centered(const PosePoint& center, const Poses& members,
                   const PoseFamily::Symmetries& symmetries) {
  Poses images;
  for (const PosePoint& member : members) {
    images.push_back(PoseFamily(center).match(member, symmetries).image);
  }
  return mean_pose(images);
}

/// The pose, of some candidates, in whose ball the most poses are.
const PosePoint& max_central(const Poses& poses, const PoseFamily::Symmetries& symmetries,
                             const PoseTolerance& tolerance) {
  const std::size_t stride = std::max<std::size_t>(1, poses.size() / kCandidates);
  std::size_t best = 0;
  std::ptrdiff_t most = 0;
  for (std::size_t i = 0; i < poses.size(); i += stride) {
    const PoseFamily ball(poses[i]);
    const auto held = std::count_if(poses.begin(), poses.end(), [&](const PosePoint& pose) {
      return ball.contains(pose, symmetries, tolerance);
    });
    if (held <= most) continue;
    most = held;
    best = i;
  }
  return poses[best];
}

/// The mean where the members are densest: next to a few that lie aside, the pose that most likely
/// is very near to the truth.
PosePoint core_of(const Poses& members, const PoseFamily::Symmetries& symmetries) {
  PosePoint center = max_central(members, symmetries, kCore);
  for (int step = 0; step < kCoreSteps; ++step) {
    center =
        centered(center, members_of(PoseFamily(center), members, symmetries, kCore), symmetries);
  }
  return center;
}

Cluster fullest_ball(const Poses& poses, const PoseFamily::Symmetries& symmetries) {
  const PosePoint& best = max_central(poses, symmetries, {});
  const PoseFamily rough(best);
  const Poses near = members_of(rough, poses, symmetries);
  const PoseFamily core(core_of(near, symmetries));
  Poses members = members_of(core, poses, symmetries);
  if (static_cast<double>(members.size()) < kCoreShare * static_cast<double>(near.size())) {
    return {rough, near};
  }
  return {core, std::move(members)};
}

Cluster fullest_cluster(const Poses& poses, const PoseFamily::Symmetries& symmetries) {
  Cluster ball = fullest_ball(poses, symmetries);
  const auto enough =
      static_cast<std::size_t>(kAxisGain * static_cast<double>(ball.members.size()));
  if (enough > poses.size()) return ball;
  const auto family = fit_free_axis(poses, ball.family.pose(), symmetries);
  if (!family) return ball;
  Poses members = members_of(*family, poses, symmetries);
  if (members.size() <= enough) return ball;
  return {centered_where_densest(*family, members, symmetries), members};
}

std::vector<Cluster> cover(Poses poses, const PoseFamily::Symmetries& symmetries,
                           std::size_t most) {
  const auto all = static_cast<double>(poses.size());
  std::vector<Cluster> clusters;
  while (clusters.size() < most && !poses.empty()) {
    Cluster cluster = fullest_cluster(poses, symmetries);
    const bool few_left = static_cast<double>(poses.size()) <= (1 - kEnoughHeld) * all;
    if (few_left && static_cast<double>(cluster.members.size()) <= kWorthListing * all) break;
    take(cluster.family, symmetries, poses);
    clusters.push_back(std::move(cluster));
  }
  std::stable_sort(clusters.begin(), clusters.end(), [](const Cluster& a, const Cluster& b) {
    return a.members.size() > b.members.size();
  });
  return clusters;
}

/// The share of the family's poses that are near its own; nothing where there are none.
std::optional<double> share_near(const PoseFamily& family, const Poses& poses,
                                 const PoseFamily::Symmetries& symmetries) {
  const Poses members = members_of(family, poses, symmetries);
  if (members.empty()) return std::nullopt;
  const Poses near = members_of(PoseFamily(family.pose()), members, symmetries);
  return std::max(kMinCount, static_cast<double>(near.size())) /
         static_cast<double>(members.size());
}

/// Spread of the members about the family, at the family's pose.
Matrix6d covariance(const Cluster& cluster, const PoseFamily::Symmetries& symmetries) {
  Matrix6d sum = Matrix6d::Zero();
  for (const PosePoint& member : cluster.members) {
    const auto match = cluster.family.match(member, symmetries);
    const PosePoint nearest = cluster.family.at(match.along);
    const Eigen::Quaterniond back = cluster.family.pose().q * nearest.q.conjugate();
    Vector6d deviation;
    deviation << back * log_so3((match.image.q * nearest.q.conjugate()).toRotationMatrix()),
        back * (match.image.t - nearest.t);
    sum += deviation * deviation.transpose();
  }
  return sum / static_cast<double>(cluster.members.size());
}

/// The nearest sequence that does not increase (pool adjacent violators).
void make_decreasing(std::vector<Mode>& modes) {
  for (std::size_t last = 1; last < modes.size(); ++last) {
    std::size_t first = last;
    double sum = modes[last].weight;
    while (first > 0 && modes[first - 1].weight < sum / static_cast<double>(last + 1 - first)) {
      sum += modes[--first].weight;
    }
    const double mean = sum / static_cast<double>(last + 1 - first);
    for (std::size_t i = first; i <= last; ++i) modes[i].weight = mean;
  }
}

}  // namespace

std::vector<Mode> find_modes(const Poses& chosen_on, const Poses& weighed_on,
                             const PoseFamily::Symmetries& symmetries, std::size_t most) {
  Poses left = weighed_on;
  std::vector<Mode> modes;
  for (const Cluster& cluster : cover(chosen_on, symmetries, most)) {
    Mode mode;
    mode.T_frame_object = cluster.family.pose().isometry();
    mode.free_axis = cluster.family.axis();
    if (mode.free_axis) mode.free_axis->share = share_near(cluster.family, left, symmetries);
    mode.weight = static_cast<double>(take(cluster.family, symmetries, left)) /
                  static_cast<double>(weighed_on.size());
    mode.covariance = covariance(cluster, symmetries);
    modes.push_back(std::move(mode));
  }
  make_decreasing(modes);
  while (modes.size() > 1 && modes.back().weight <= 0) modes.pop_back();
  const double least = kMinCount / static_cast<double>(weighed_on.size());
  if (!modes.empty()) modes.front().weight = std::max(modes.front().weight, least);
  return modes;
}

}  // namespace palpate::localization
