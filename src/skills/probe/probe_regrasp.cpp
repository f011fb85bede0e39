// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/probe_regrasp.hpp"

#include <algorithm>
#include <numeric>

#include "palpate/localization/consensus.hpp"

namespace palpate::skills {
namespace {

constexpr std::size_t kFinalists = 12;                 // grasps that are compared
constexpr double kSameAttitude = 1e-6;                 // rad
constexpr localization::SamePose kStirred{0.2, 0.01};  // closing turns such poses into one another

using localization::PredictedTouches;

/// The cheapest grasp from each side that holds the object at a pose, the cheapest of all first.
std::vector<grasping::GraspPlan> grasps_from_all_sides(const geometry::ObjectModel& object,
                                                       const Eigen::Isometry3d& T_world_object,
                                                       const GraspTool& tool,
                                                       const InformativeGraspOptions& options) {
  std::vector<grasping::GraspPlan> found;
  for (const auto& attitude : tool.attitudes) {
    for (auto& grasp : grasping::find_grasps(object, T_world_object, tool.path, attitude,
                                             options.plan, options.avoid)) {
      if (grasp.cost < options.worst_cost) found.push_back(std::move(grasp));
    }
  }
  std::stable_sort(
      found.begin(), found.end(),
      [](const grasping::GraspPlan& a, const grasping::GraspPlan& b) { return a.cost < b.cost; });
  std::vector<grasping::GraspPlan> sides;
  for (auto& grasp : found) {
    if (sides.size() == kFinalists) break;
    const bool known =
        std::any_of(sides.begin(), sides.end(), [&](const grasping::GraspPlan& other) {
          return (other.mount.ypr - grasp.mount.ypr).cwiseAbs().maxCoeff() < kSameAttitude;
        });
    if (!known) sides.push_back(std::move(grasp));
  }
  return sides;
}

/// Way of each fingertip along its closing up to each shape, m.
using TipWays = std::vector<std::vector<double>>;

TipWays tip_ways(const grasping::ClosingTrajectory& path) {
  TipWays ways(path.fingers.size());
  for (std::size_t finger = 0; finger < path.fingers.size(); ++finger) {
    double way = 0;
    const grasping::FingerShape* before = nullptr;
    for (const grasping::FingerShape& shape : path.fingers[finger]) {
      if (before) way += static_cast<double>((shape.tip.back() - before->tip.back()).norm());
      ways[finger].push_back(way);
      before = &shape;
    }
  }
  return ways;
}

/// What the fingers sense when they have closed.
PredictedTouches predicted_touches(const grasping::GraspPlan& closed, const TipWays& ways) {
  PredictedTouches touches(ways.size());
  for (const auto& contact : closed.contacts) {
    const auto finger = static_cast<std::size_t>(contact.finger);
    touches[finger] = {true, ways[finger][closed.stops[finger]], contact.n};
  }
  return touches;
}

}  // namespace

std::optional<InformativeGrasp> most_informative_grasp(const geometry::ObjectModel& object,
                                                       const localization::Posterior& resting,
                                                       const GraspTool& tool,
                                                       const InformativeGraspOptions& options) {
  if (resting.modes.empty()) return std::nullopt;
  const auto poses = localization::poses_of(resting);
  std::vector<double> weights;
  for (const localization::WeightedPose& pose : poses) weights.push_back(pose.weight);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const TipWays ways = tip_ways(tool.path);
  std::optional<InformativeGrasp> best;
  for (const grasping::GraspPlan& grasp :
       grasps_from_all_sides(object, resting.modes.front().T_frame_object, tool, options)) {
    std::vector<PredictedTouches> touches;
    double holds = 0;
    for (const localization::WeightedPose& pose : poses) {
      const auto closed =
          grasping::close_virtually(object, pose.T, tool.path, grasp.mount, options.plan);
      if (closed && closed->cost < options.worst_cost) holds += pose.weight;
      touches.push_back(closed ? predicted_touches(*closed, ways) : PredictedTouches(ways.size()));
    }
    if (holds < options.likely * total) continue;
    const double information =
        localization::information_bound(touches, weights, touches_of_modes());
    if (best && information <= best->expected_gain.information) continue;
    best = InformativeGrasp{grasp, {information, options.seconds}};
  }
  if (best) {
    double& information = best->expected_gain.information;
    information = std::min(information, localization::entropy(poses, kStirred));
  }
  return best;
}

}  // namespace palpate::skills
