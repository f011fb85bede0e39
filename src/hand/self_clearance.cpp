// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/self_clearance.hpp"

#include <algorithm>

namespace palpate::hand {
namespace {

constexpr double kClearance = 0.002;  // m that links of different fingers are to keep
constexpr int kOuter = 3;             // joints from the palm, from where on a link may meet it

int parent_of(const Description& hand, int link) {
  return hand.links[static_cast<std::size_t>(link)].parent;
}

/// Joints between the palm and a link.
int depth_of(const Description& hand, int link) {
  int depth = 0;
  for (; link >= 0 && link != hand.palm; link = parent_of(hand, link)) {
    depth += hand.links[static_cast<std::size_t>(link)].joint >= 0;
  }
  return depth;
}

}  // namespace

SelfClearance::SelfClearance(const Description& hand, const JointVector& possible)
    : hand_(hand), finger_(hand.links.size(), -1) {
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    int link = hand.fingers[static_cast<std::size_t>(finger)].link;
    for (; link >= 0 && link != hand.palm; link = parent_of(hand, link)) {
      finger_[static_cast<std::size_t>(link)] = finger;
    }
  }
  for (std::size_t link = 0; link < hand.links.size(); ++link) {
    outer_.push_back(depth_of(hand, static_cast<int>(link)) >= kOuter);
  }
  possible_ = close_links(possible);
}

bool SelfClearance::is_clear(const JointVector& joints) const {
  const LinkPairs now = close_links(joints);
  return std::includes(possible_.begin(), possible_.end(), now.begin(), now.end());
}

/// Whether two balls are of different fingers, or of a finger's outer links and the palm.
bool SelfClearance::may_meet(const LinkSphere& ball, const LinkSphere& other) const {
  const auto a = static_cast<std::size_t>(ball.link), b = static_cast<std::size_t>(other.link);
  if (finger_[a] == finger_[b]) return false;
  return (finger_[a] >= 0 || outer_[b]) && (finger_[b] >= 0 || outer_[a]);
}

SelfClearance::LinkPairs SelfClearance::close_links(const JointVector& joints) const {
  const auto T = forward_kinematics(hand_, joints);
  const auto& balls = hand_.spheres;
  std::vector<Eigen::Vector3d> centers;
  for (const LinkSphere& ball : balls) {
    centers.emplace_back(T[static_cast<std::size_t>(ball.link)] * ball.center);
  }
  LinkPairs pairs;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double reach = balls[i].radius + balls[k].radius + kClearance;
      if ((centers[i] - centers[k]).squaredNorm() > reach * reach) continue;
      if (may_meet(balls[i], balls[k])) pairs.insert(std::minmax(balls[i].link, balls[k].link));
    }
  }
  return pairs;
}

}  // namespace palpate::hand
