// SPDX-License-Identifier: Apache-2.0
#include "skills/reorient/transfer_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/se3.hpp"
#include "palpate/hand/nearest_mount.hpp"

namespace palpate::skills {
namespace {

constexpr std::size_t kCompared = 12;
constexpr std::size_t kAskedFor = 100;  // holds, whether the hand can be brought there
constexpr std::array<double, 4> kRise = {0.1, 0.3, 0.6, 1.0};  // shares of the retreat
constexpr float kFree = 0.002f;  // m, between the rising hand and the object

void add_finger(const grasping::FingerShape& shape, float radius,
                std::vector<Eigen::Vector4f>& spheres) {
  spheres.insert(spheres.end(), shape.other_spheres.begin(), shape.other_spheres.end());
  for (const auto& p : shape.tip) {
    spheres.emplace_back();
    spheres.back() << p, radius;
  }
}

/// The hand opened and closed around the object.
std::vector<Eigen::Vector4f> room_of(const grasping::ClosingTrajectory& path,
                                     const grasping::GraspPlan& grasp) {
  auto spheres = path.open_spheres;
  for (std::size_t finger = 0; finger < path.fingers.size(); ++finger) {
    add_finger(path.fingers[finger][grasp.stops[finger]], path.tip_radius[finger], spheres);
  }
  return spheres;
}

}  // namespace

std::vector<Hold> holds_of(const geometry::ObjectModel& object, const GraspTool& tool,
                           const Eigen::Isometry3d& T_world_object, const RegraspOptions& options) {
  std::vector<Hold> holds;
  for (const auto& attitude : tool.attitudes) {
    for (auto& grasp :
         grasping::find_grasps(object, T_world_object, tool.path, attitude, options.grasp)) {
      if (grasp.cost > options.worst_grasp) continue;
      const Eigen::Isometry3d T_mount_world = grasp.mount.pose().inverse();
      Hold hold;
      hold.mount = grasp.mount;
      hold.T_mount_object = T_mount_world * T_world_object;
      hold.spheres = room_of(tool.path, grasp);
      hold.grasp = std::move(grasp);
      holds.push_back(std::move(hold));
    }
  }
  return holds;
}

Hold hold_of(const hand::Description& hand, const Holding& holding,
             const Eigen::Isometry3d& T_world_object) {
  Hold hold;
  hold.mount = holding.mount;
  hold.T_mount_object = holding.mount.pose().inverse() * T_world_object;
  const auto T_mount_link = hand::forward_kinematics(hand, holding.joints);
  for (const auto& sphere : hand.spheres) {
    const Eigen::Vector3d center =
        T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center;
    hold.spheres.emplace_back();
    hold.spheres.back() << center.cast<float>(), static_cast<float>(sphere.radius);
  }
  return hold;
}

void TransferSearch::set_goal(const Eigen::Isometry3d& T_world_to, bool free_yaw) {
  to_ = T_world_to;
  turn_ = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& S : object_.object().symmetries) {
    Eigen::Matrix3d R = T_world_to.linear() * S;
    const Eigen::Matrix3d M = R * from_.linear().transpose();
    // The yaw that makes the trace of Rz(yaw) M largest, and with it the turn smallest.
    const double yaw = free_yaw ? std::atan2(M(0, 1) - M(1, 0), M(0, 0) + M(1, 1)) : 0;
    R = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * R;
    const double turn = rotation_distance(R, from_.linear());
    if (turn >= turn_ - 1e-9) continue;
    turn_ = turn;
    to_.linear() = R;
  }
}

/// Lowest point of the hand where it lets go and where it has withdrawn, m above the table.
double TransferSearch::clearance(const Hold& hold) const {
  const Eigen::Isometry3d T_world_mount = to_ * hold.T_mount_object.inverse();
  const Eigen::RowVector3f up = T_world_mount.linear().row(2).cast<float>();
  float low = std::numeric_limits<float>::infinity();
  for (const auto& sphere : hold.spheres) {
    low = std::min(low, up.dot(sphere.head<3>()) - sphere.w());
  }
  return T_world_mount.translation().z() + static_cast<double>(low);
}

/// Whether the opened hand leaves the object behind when it rises.
bool TransferSearch::rises_freely(const Hold& hold) const {
  const auto& field = object_.field();
  const Eigen::Isometry3f T_object_mount = hold.T_mount_object.inverse().cast<float>();
  const Eigen::Vector3f up = to_.linear().row(2).transpose().cast<float>();
  for (const auto& sphere : tool_.path.open_spheres) {
    for (const double share : kRise) {
      const Eigen::Vector3f raised =
          T_object_mount * sphere.head<3>() + static_cast<float>(share * options_.retreat) * up;
      if (field.distance(raised) < std::min(sphere.w() + kFree, field.beyond())) return false;
    }
  }
  return true;
}

/// What the grasp costs where it starts and, with gravity pulling otherwise, where it ends.
double TransferSearch::cost(const Hold& hold) const {
  const double moving = options_.transfer_cost + options_.turn_cost * turn_;
  if (!hold.grasp) return moving;
  const Eigen::Isometry3d T_world_mount = to_ * hold.T_mount_object.inverse();
  const double at_end = grasping::grasp_cost(object_, *hold.grasp, options_.grasp,
                                             -T_world_mount.linear().row(2).transpose(),
                                             hold.T_mount_object.translation());
  if (at_end > options_.worst_grasp) return std::numeric_limits<double>::infinity();
  return moving + hold.grasp->cost + at_end;
}

/// The mount where the hand lets go.
hand::MountPosition TransferSearch::release(const Hold& hold) const {
  return hand::nearest_mount(to_ * hold.T_mount_object.inverse(), hold.mount);
}

bool TransferSearch::reachable(const Choice& choice) const {
  const Hold& hold = *choice.hold;
  if (!hold.reachable) hold.reachable = !hold.grasp || tool_.reaches(hold.mount);
  return *hold.reachable && tool_.releases(release(hold));
}

Transfer TransferSearch::transfer(const Choice& choice) const {
  Transfer transfer;
  transfer.grasp = choice.hold->grasp;
  transfer.T_world_from = from_;
  transfer.T_world_to = to_;
  transfer.release = release(*choice.hold);
  transfer.turn = turn_;
  transfer.clearance = choice.clearance;
  transfer.cost = choice.cost;
  return transfer;
}

std::optional<Transfer> TransferSearch::cheapest(const std::vector<Hold>& holds, bool from_start) {
  std::vector<Choice> choices;
  for (const Hold& hold : holds) {
    const double above = clearance(hold);
    largest_clearance_ = std::max(largest_clearance_, above);
    if (above < options_.clearance || (hold.grasp && !rises_freely(hold))) continue;
    const double cost_of_hold = cost(hold);
    if (std::isfinite(cost_of_hold)) choices.push_back({&hold, above, cost_of_hold});
  }
  if (choices.empty()) return std::nullopt;
  const auto cheaper = [](const Choice& a, const Choice& b) { return a.cost < b.cost; };
  std::stable_sort(choices.begin(), choices.end(), cheaper);
  if (from_start && tool_.reaches && tool_.releases) {
    std::vector<Choice> reached;
    for (std::size_t i = 0; i < std::min(choices.size(), kAskedFor); ++i) {
      if (reached.size() < kCompared && reachable(choices[i])) reached.push_back(choices[i]);
    }
    out_of_reach_ = reached.empty();
    if (out_of_reach_) return std::nullopt;
    choices = std::move(reached);
  }
  choices.resize(std::min(choices.size(), kCompared));
  for (Choice& choice : choices) {
    if (!choice.hold->grasp) continue;
    const grasping::GraspPlan& grasp = *choice.hold->grasp;
    choice.cost +=
        grasping::mean_cost(object_, from_, tool_.path, options_.grasp, grasp) - grasp.cost;
  }
  return transfer(*std::min_element(choices.begin(), choices.end(), cheaper));
}

}  // namespace palpate::skills
