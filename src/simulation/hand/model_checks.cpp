// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/model_checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "simulation/hand/anatomy.hpp"
#include "simulation/hand/mimic_joints.hpp"

namespace palpate::simulation {
namespace {

constexpr double kShortest = 0.01, kLongest = 0.6;  // m, from the palm to a fingertip
constexpr double kWidest = 0.06;                    // m, half width of a fingertip
constexpr double kLargest = 2;                      // m, radius of the ball about a shape
constexpr std::size_t kNamed = 3;                   // of many
constexpr const char* kInMetres =
    "lengths are metres; if the model or its meshes are in millimetres, scale them by 0.001";

}  // namespace

void refuse_closed_loops(const mjModel& model) {
  for (int i = 0; i < model.neq; ++i) {
    if (!model.eq_active0[i]) continue;
    if (model.eq_type[i] != mjEQ_CONNECT && model.eq_type[i] != mjEQ_WELD) continue;
    const bool sites = model.eq_objtype[i] == mjOBJ_SITE;
    const auto body = [&](int id) {
      return model_name(model, mjOBJ_BODY, sites ? model.site_bodyid[id] : id);
    };
    throw BadInput(fmt::format("links {} and {} are tied in a closed loop, which is not supported",
                               body(model.eq_obj1id[i]), body(model.eq_obj2id[i])));
  }
}

void check_shapes(const mjModel& model) {
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (model.geom_rbound[geom] < kLargest) continue;
    throw BadInput(fmt::format("a shape of link {} is {:.3g} m large: {}",
                               model_name(model, mjOBJ_BODY, model.geom_bodyid[geom]),
                               2 * model.geom_rbound[geom], kInMetres));
  }
}

void check_size(const hand::Description& hand) {
  const auto T = hand::forward_kinematics(hand, hand::JointVector::Zero(hand.joint_count()));
  const Eigen::Vector3d palm = T[static_cast<std::size_t>(hand.palm)].translation();
  for (const hand::Finger& finger : hand.fingers) {
    const Eigen::Vector3d tip = T[static_cast<std::size_t>(finger.link)] * finger.tip.b;
    const double reach = (tip - palm).norm();
    if (reach > kShortest && reach < kLongest && finger.tip.radius < kWidest) continue;
    throw BadInput(fmt::format("fingertip {} is {:.3g} m from the palm and {:.3g} m wide: {}",
                               hand.links[static_cast<std::size_t>(finger.link)].name, reach,
                               2 * finger.tip.radius, kInMetres));
  }
}

std::string first_of(std::span<const std::string> names) {
  const auto first = names.first(std::min(kNamed, names.size()));
  std::string text = fmt::format("{}", fmt::join(first, ", "));
  if (first.size() < names.size()) {
    text += fmt::format(" and {} more", names.size() - first.size());
  }
  return text;
}

std::string left_out_tendons(const mjModel& model) {
  std::vector<std::string> names;
  for (int i = 0; i < model.ntendon; ++i) {
    if (!ties_joints(model, i)) names.push_back(model_name(model, mjOBJ_TENDON, i));
  }
  if (names.empty()) return {};
  if (names.size() == 1) return fmt::format("tendon {} is left out", names[0]);
  return fmt::format("tendons {} are left out", first_of(names));
}

int springs(const mjModel& model) {
  return static_cast<int>(std::count_if(model.jnt_stiffness, model.jnt_stiffness + model.njnt,
                                        [](double stiffness) { return stiffness != 0; }));
}

void check_limits(const std::string& joint, const hand::Range& range) {
  constexpr double kTurn = 2 * std::numbers::pi * 1.01;  // 6.2832, rounded, is no error
  const double most = std::max(std::abs(range.low), std::abs(range.high));
  if (most <= kTurn) return;
  throw BadInput(fmt::format("joint {} has the limits {:.4g} .. {:.4g} rad; are these degrees?",
                             joint, range.low, range.high));
}

}  // namespace palpate::simulation
