// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/self_distance.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace palpate::hand {
namespace {

constexpr double kClearance = 0.002;  // m that links of different fingers are to keep
constexpr int kOuter = 3;             // joints from the palm, from where on a link may meet it

int parent_of(const Description& hand, int link) {
  return hand.links[static_cast<std::size_t>(link)].parent;
}

/// The finger that carries each link; -1: the palm and what is before it.
std::vector<int> owners(const Description& hand) {
  std::vector<int> owner(hand.links.size(), -1);
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    int link = hand.fingers[static_cast<std::size_t>(finger)].link;
    for (; link >= 0 && link != hand.palm; link = parent_of(hand, link)) {
      owner[static_cast<std::size_t>(link)] = finger;
    }
  }
  return owner;
}

/// Joints between the palm and a link.
int depth_of(const Description& hand, int link) {
  int depth = 0;
  for (; link >= 0 && link != hand.palm; link = parent_of(hand, link)) {
    depth += hand.links[static_cast<std::size_t>(link)].joint >= 0;
  }
  return depth;
}

/// Pairs of links, of different fingers or of a finger's outer links and the palm, whose balls are
/// nearer than kClearance.
std::set<std::pair<int, int>> close_pairs(const Description& hand, const JointVector& joints) {
  const auto owner = owners(hand);
  const auto T = forward_kinematics(hand, joints);
  const auto center = [&](const LinkSphere& ball) -> Eigen::Vector3d {
    return T[static_cast<std::size_t>(ball.link)] * ball.center;
  };
  std::set<std::pair<int, int>> pairs;
  for (const LinkSphere& ball : hand.spheres) {
    const int own = owner[static_cast<std::size_t>(ball.link)];
    if (own < 0) continue;
    const bool outer = depth_of(hand, ball.link) >= kOuter;
    for (const LinkSphere& other : hand.spheres) {
      const int finger = owner[static_cast<std::size_t>(other.link)];
      if (finger == own || (finger < 0 && !outer)) continue;
      const double way = (center(ball) - center(other)).norm();
      if (way - ball.radius - other.radius > kClearance) continue;
      pairs.insert({std::min(ball.link, other.link), std::max(ball.link, other.link)});
    }
  }
  return pairs;
}

}  // namespace

bool is_clear_of_itself(const Description& hand, const JointVector& joints,
                        const JointVector& possible) {
  const auto known = close_pairs(hand, possible);
  const auto now = close_pairs(hand, joints);
  return std::includes(known.begin(), known.end(), now.begin(), now.end());
}

}  // namespace palpate::hand
