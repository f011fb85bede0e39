// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/mimic_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::simulation {
namespace {

constexpr double kMinRange = 0.1;  // rad

/// Two joints of the model: angle = offset + ratio * the leader's.
struct Tie {
  int joint, leader;
  double ratio, offset;
};

/// Whether the limits of both joints leave them a range in which one follows the other.
bool can_move(const mjModel& model, const Tie& tie) {
  if (!model.jnt_limited[tie.joint] || !model.jnt_limited[tie.leader]) return true;
  const mjtNum* const own = model.jnt_range + 2 * tie.joint;
  const mjtNum* const leading = model.jnt_range + 2 * tie.leader;
  const auto [low, high] =
      std::minmax({tie.offset + tie.ratio * leading[0], tie.offset + tie.ratio * leading[1]});
  return std::min(high, own[1]) - std::max(low, own[0]) > kMinRange;
}

/// The tie of an equality that holds a fixed tendon of two joints at its length. None where the
/// joints' limits contradict it: such files rely on a soft equality.
std::optional<Tie> tie_by_tendon(const mjModel& model, int equality) {
  if (model.eq_type[equality] != mjEQ_TENDON || model.eq_obj2id[equality] >= 0) return {};
  const int tendon = model.eq_obj1id[equality], first = model.tendon_adr[tendon];
  if (model.tendon_num[tendon] != 2) return {};
  for (int wrap = first; wrap < first + 2; ++wrap) {
    if (model.wrap_type[wrap] != mjWRAP_JOINT || model.wrap_prm[wrap] == 0) return {};
  }
  const double pull = model.wrap_prm[first], of_leader = model.wrap_prm[first + 1];
  const double length = model.tendon_length0[tendon] + model.eq_data[mjNEQDATA * equality];
  const Tie tie{model.wrap_objid[first], model.wrap_objid[first + 1], -of_leader / pull,
                length / pull};
  return can_move(model, tie) ? std::optional(tie) : std::nullopt;
}

/// What the active equalities of joints, and of tendons, say. A joint that is locked is its own
/// leader, by 0.
std::vector<Tie> read_ties(const mjModel& model) {
  std::vector<Tie> ties;
  for (int i = 0; i < model.neq; ++i) {
    if (!model.eq_active0[i]) continue;
    if (const auto tie = tie_by_tendon(model, i)) ties.push_back(*tie);
    if (model.eq_type[i] != mjEQ_JOINT) continue;
    const int joint = model.eq_obj1id[i], leader = model.eq_obj2id[i];
    const mjtNum* const data = model.eq_data + mjNEQDATA * i;  // polynomial of the leader's way
    const bool locked = leader < 0;
    if (!locked && (data[2] != 0 || data[3] != 0 || data[4] != 0)) {
      throw BadInput(fmt::format(
          "the equality of joint {} is no linear one (polycoef {} {} {} {} {})",
          mj_id2name(&model, mjOBJ_JOINT, joint), data[0], data[1], data[2], data[3], data[4]));
    }
    const auto drawn_at = [&](int id) { return model.qpos0[model.jnt_qposadr[id]]; };
    const double ratio = locked ? 0 : data[1];
    const double offset = data[0] + drawn_at(joint) - (ratio == 0 ? 0 : ratio * drawn_at(leader));
    ties.push_back({joint, ratio == 0 ? joint : leader, ratio, offset});
  }
  return ties;
}

bool is_lock(const Tie& tie) { return tie.ratio == 0; }

Tie reversed(const Tie& tie) {
  return {tie.leader, tie.joint, 1 / tie.ratio, -tie.offset / tie.ratio};
}

/// A joint and all that are tied to it, by it. @throws BadInput for ties in a circle
std::vector<Tie> followers(const mjModel& model, const std::vector<Tie>& ties, int leader) {
  std::vector<Tie> found{{leader, leader, 1, 0}};
  std::vector<bool> used(ties.size());
  for (std::size_t at = 0; at < found.size(); ++at) {
    for (std::size_t i = 0; i < ties.size(); ++i) {
      const Tie from = found[at];
      const bool leads = ties[i].leader == from.joint;
      if (used[i] || is_lock(ties[i]) || (!leads && ties[i].joint != from.joint)) continue;
      used[i] = true;
      const Tie next = leads ? ties[i] : reversed(ties[i]);
      if (std::ranges::find(found, next.joint, &Tie::joint) != found.end()) {
        throw BadInput(fmt::format("joint {} is tied to others in a circle",
                                   mj_id2name(&model, mjOBJ_JOINT, next.joint)));
      }
      found.push_back(
          {next.joint, leader, next.ratio * from.ratio, next.offset + next.ratio * from.offset});
    }
  }
  return found;
}

bool is_actuated(const mjModel& model, int joint) {
  for (int i = 0; i < model.nu; ++i) {
    const int type = model.actuator_trntype[i];
    if ((type == mjTRN_JOINT || type == mjTRN_JOINTINPARENT) &&
        model.actuator_trnid[2 * i] == joint) {
      return true;
    }
  }
  return false;
}

/// Of joints that are tied: the locked one, else the one with an actuator, else the only one that
/// no equality lets follow another, else the one with most ties.
int leader_of(const mjModel& model, const std::vector<Tie>& ties, const std::vector<Tie>& group) {
  const auto is_led = [&](const Tie& one) {
    return std::ranges::any_of(
        ties, [&](const Tie& tie) { return !is_lock(tie) && tie.joint == one.joint; });
  };
  const bool one_leads = std::ranges::count(group, false, is_led) == 1;
  const auto rank = [&](const Tie& one) {
    std::ptrdiff_t locks = 0, count = 0;
    for (const Tie& tie : ties) {
      locks += is_lock(tie) && tie.joint == one.joint;
      count += tie.joint == one.joint || tie.leader == one.joint;
    }
    return std::tuple(locks > 0, is_actuated(model, one.joint), one_leads && !is_led(one), count,
                      -one.joint);
  };
  return std::ranges::max_element(group, {}, rank)->joint;
}

/// The free joint that is nearest to a locked one, along its finger if there is one.
int companion(const mjModel& model, const std::vector<Tie>& tied, int locked) {
  const auto carries = [&](int above, int joint) {
    int body = model.jnt_bodyid[joint];
    while (body > model.jnt_bodyid[above]) body = model.body_parentid[body];
    return body == model.jnt_bodyid[above];
  };
  int nearest = -1;
  auto least = std::pair(true, static_cast<int>(model.njnt));
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (std::ranges::find(tied, joint, &Tie::joint) != tied.end()) continue;
    const bool apart = !carries(joint, locked) && !carries(locked, joint);
    const auto distance = std::pair(apart, std::abs(joint - locked));
    if (distance >= least) continue;
    least = distance;
    nearest = joint;
  }
  if (nearest < 0) throw BadInput("all joints are locked by equalities");
  return nearest;
}

std::vector<MimicJoint> of_equalities(const mjModel& model) {
  const std::vector<Tie> ties = read_ties(model);
  std::vector<Tie> tied;  // every joint that is not free
  std::vector<bool> seen(static_cast<std::size_t>(model.njnt));
  for (const Tie& tie : ties) {
    if (seen[static_cast<std::size_t>(tie.joint)]) continue;
    const int leader = leader_of(model, ties, followers(model, ties, tie.joint));
    const auto lock = std::ranges::find_if(
        ties, [&](const Tie& one) { return is_lock(one) && one.joint == leader; });
    for (Tie one : followers(model, ties, leader)) {
      seen[static_cast<std::size_t>(one.joint)] = true;
      if (lock != ties.end()) one = {one.joint, -1, 0, one.offset + one.ratio * lock->offset};
      if (one.joint != leader || is_lock(one)) tied.push_back(one);
    }
  }
  std::vector<MimicJoint> mimics;
  for (const Tie& one : tied) {
    const int leader = is_lock(one) ? companion(model, tied, one.joint) : one.leader;
    mimics.push_back({mj_id2name(&model, mjOBJ_JOINT, one.joint),
                      mj_id2name(&model, mjOBJ_JOINT, leader), one.ratio, one.offset});
  }
  return mimics;
}

/// Makes followers of followers follow the first leader.
void resolve(std::vector<MimicJoint>& mimics) {
  for (MimicJoint& mimic : mimics) {
    for (std::size_t hops = 0;; ++hops) {
      const auto leader = std::find_if(mimics.begin(), mimics.end(), [&](const MimicJoint& other) {
        return other.joint == mimic.leader;
      });
      if (leader == mimics.end()) break;
      if (hops > mimics.size() || leader->joint == mimic.joint) {
        throw BadInput(fmt::format("joint {} follows itself in a circle of mimics", mimic.joint));
      }
      mimic.offset += mimic.ratio * leader->offset;
      mimic.ratio *= leader->ratio;
      mimic.leader = leader->leader;
    }
  }
}

}  // namespace

bool ties_joints(const mjModel& model, int tendon) {
  for (int i = 0; i < model.neq; ++i) {
    if (model.eq_active0[i] && model.eq_obj1id[i] == tendon && tie_by_tendon(model, i)) return true;
  }
  return false;
}

std::vector<MimicJoint> mimic_joints(const mjModel& model, const std::filesystem::path& file) {
  // Of a URDF the simulator leaves out mimics that it does not understand.
  auto mimics = is_urdf(file) ? read_urdf(file).mimics : of_equalities(model);
  resolve(mimics);
  std::erase_if(mimics, [&](const MimicJoint& one) {  // of what is left out
    return mj_name2id(&model, mjOBJ_JOINT, one.joint.c_str()) < 0;
  });
  for (const MimicJoint& mimic : mimics) {
    if (mj_name2id(&model, mjOBJ_JOINT, mimic.leader.c_str()) >= 0) continue;
    throw BadInput(
        fmt::format("joint {} follows {}, which the hand lacks", mimic.joint, mimic.leader));
  }
  return mimics;
}

}  // namespace palpate::simulation
