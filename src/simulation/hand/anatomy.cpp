// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/anatomy.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

constexpr std::string_view kSeparators = "_-.";  // within names
constexpr int kJointsOfAHand = 4;                // at least, of what may be another one

int joints_below(mjsBody& body, bool hinges_only = false) {
  int count = 0;
  for (mjsElement* e = mjs_firstChild(&body, mjOBJ_JOINT, 1); e; e = mjs_nextChild(&body, e, 1)) {
    count += !hinges_only || mjs_asJoint(e)->type == mjJNT_HINGE;
  }
  return count;
}

}  // namespace

std::vector<std::string> listed(std::string_view key, std::string_view names) {
  std::vector<std::string> list;
  if (names.empty()) return list;
  for (const std::string_view name : csv_cells(names)) {
    if (name.empty()) throw BadInput(fmt::format("{} = '{}' has an empty name", key, names));
    if (std::ranges::find(list, name) != list.end()) {
      throw BadInput(fmt::format("{} names {} twice", key, name));
    }
    list.emplace_back(name);
  }
  return list;
}

std::string model_name(const mjModel& model, mjtObj type, int id) {
  const char* name = mj_id2name(&model, type, id);
  return name ? name : "";
}

std::string find_root(mjSpec& spec, const HandNotes& notes) {
  if (!notes.root.empty()) return notes.root;
  mjsBody* world = mjs_findBody(&spec, "world");
  std::string root;
  int most = 0;
  for (mjsElement* e = mjs_firstChild(world, mjOBJ_BODY, 0); e; e = mjs_nextChild(world, e, 0)) {
    mjsBody& body = *mjs_asBody(e);
    const int joints = joints_below(body);
    if (joints <= most) continue;
    most = joints;
    root = mjs_getString(mjs_getName(e));
  }
  if (root.empty()) throw BadInput("no body of the file has joints: is it a hand?");
  return root;
}

std::string another_hand(mjSpec& spec, const std::string& root) {
  mjsBody* world = mjs_findBody(&spec, "world");
  for (mjsElement* e = mjs_firstChild(world, mjOBJ_BODY, 0); e; e = mjs_nextChild(world, e, 0)) {
    const std::string name = mjs_getString(mjs_getName(e));
    const int hinges = joints_below(*mjs_asBody(e), true);
    if (name == root || hinges < kJointsOfAHand) continue;
    return fmt::format("the file has another body with {} hinges, {}, which is left out", hinges,
                       name);
  }
  return {};
}

Anatomy::Anatomy(const mjModel& model, const std::string& root, const HandNotes& notes,
                 const std::vector<MimicJoint>& mimics)
    : model_(model),
      root_(find_id(model, mjOBJ_BODY, root)),
      follows_(static_cast<std::size_t>(model.njnt)) {
  for (const MimicJoint& mimic : mimics) {
    const int joint = mj_name2id(&model, mjOBJ_JOINT, mimic.joint.c_str());
    if (joint >= 0) follows_[static_cast<std::size_t>(joint)] = true;
  }
  children_.resize(static_cast<std::size_t>(model.nbody));
  for (int body = root_ + 1; body < model.nbody; ++body) {
    if (is_below(body))
      children_[static_cast<std::size_t>(model.body_parentid[body])].push_back(body);
  }
  palm_ = notes.palm.empty() ? find_palm() : find_id(model, mjOBJ_BODY, notes.palm);
  find_fingers(notes);
}

int Anatomy::joints_in(int body) const {
  int count = model_.body_jntnum[body];
  for (const int child : children(body)) count += joints_in(child);
  return count;
}

int Anatomy::driven_joints_in(int body) const {
  int count = 0;
  for (int i = 0; i < model_.body_jntnum[body]; ++i) {
    count += !follows_[static_cast<std::size_t>(model_.body_jntadr[body] + i)];
  }
  for (const int child : children(body)) count += driven_joints_in(child);
  return count;
}

bool Anatomy::collides(int body) const {
  for (int i = 0; i < model_.body_geomnum[body]; ++i) {
    const int geom = model_.body_geomadr[body] + i;
    if (model_.geom_contype[geom] != 0 || model_.geom_conaffinity[geom] != 0) return true;
  }
  return false;
}

/// The first body from the root on from which several chains of joints go out.
int Anatomy::find_palm() const {
  int body = root_;
  while (true) {
    std::vector<int> jointed;
    for (const int child : children(body)) {
      if (joints_in(child) > 0) jointed.push_back(child);
    }
    if (jointed.size() != 1) return body;
    body = jointed.front();
  }
}

/// From a body to the end of its longest branch that can collide.
std::vector<int> Anatomy::longest_chain(int body) const {
  std::vector<int> best;
  for (const int child : children(body)) {
    auto chain = longest_chain(child);
    if (chain.size() > best.size()) best = std::move(chain);
  }
  if (best.empty() && !collides(body)) return {};
  best.insert(best.begin(), body);
  return best;
}

/// Children that lead to a finger of its own: with a drive and something that can collide.
std::vector<int> Anatomy::limbs(int body) const {
  std::vector<int> result;
  for (const int child : children(body)) {
    if (driven_joints_in(child) > 0 && !longest_chain(child).empty()) result.push_back(child);
  }
  return result;
}

/// Adds the finger that begins at a body; where it branches into several, as behind a part of the
/// palm that moves, those in its place.
void Anatomy::add_fingers(int body) {
  std::vector<int> branches = limbs(body);
  while (branches.size() == 1) branches = limbs(branches.front());
  for (const int branch : branches) add_fingers(branch);
  if (!branches.empty()) return;
  Chain chain;
  chain.bodies = longest_chain(body);
  if (chain.bodies.empty()) return;
  chain.tip = chain.bodies.back();
  fingers_.push_back(chain);
}

void Anatomy::find_fingers(const HandNotes& notes) {
  for (const int child : children(palm_)) {
    if (joints_in(child) > 0) add_fingers(child);
  }
  choose_tips(notes);
  const auto names = listed("fingers", notes.fingers);
  if (!names.empty() && names.size() != fingers_.size()) {
    throw BadInput(fmt::format("fingers = '{}' names {} fingers, but the hand has {}",
                               notes.fingers, names.size(), fingers_.size()));
  }
  for (std::size_t i = 0; i < fingers_.size(); ++i) {
    fingers_[i].name = names.empty() ? model_name(model_, mjOBJ_BODY, fingers_[i].tip) : names[i];
  }
}

/// The bodies from the palm to a fingertip that the user names.
Chain Anatomy::chain_to(const std::string& name) const {
  Chain chain;
  chain.tip = find_id(model_, mjOBJ_BODY, name);
  if (!is_below(chain.tip)) {
    throw BadInput(fmt::format("the fingertip {} is not below the hand's root {}", name,
                               model_name(model_, mjOBJ_BODY, root_)));
  }
  int joints = 0;
  for (int body = chain.tip; body > 0 && body != palm_; body = model_.body_parentid[body]) {
    chain.bodies.insert(chain.bodies.begin(), body);
    if (body != root_) joints += model_.body_jntnum[body];
  }
  if (joints == 0) {
    throw BadInput(fmt::format("tips: no joint moves {}; name the last body of each finger", name));
  }
  return chain;
}

void Anatomy::choose_tips(const HandNotes& notes) {
  if (notes.tips.empty()) return;
  std::vector<Chain> chosen;
  for (const std::string& name : listed("tips", notes.tips)) {
    const Chain chain = chain_to(name);
    for (const Chain& other : chosen) {
      if (!is_below(chain.tip, other.tip) && !is_below(other.tip, chain.tip)) continue;
      throw BadInput(fmt::format("tips: {} and {} are of one finger", name,
                                 model_name(model_, mjOBJ_BODY, other.tip)));
    }
    chosen.push_back(chain);
  }
  fingers_ = chosen;
}

/// Whether a body is part of one of the fingers.
bool Anatomy::is_in_finger(int body) const {
  return std::ranges::any_of(
      fingers_, [&](const Chain& finger) { return std::ranges::count(finger.bodies, body) > 0; });
}

/// Whether a body carries a fingertip.
bool Anatomy::carries_tip(int body) const {
  return std::ranges::any_of(fingers_,
                             [&](const Chain& finger) { return is_below(finger.tip, body); });
}

std::vector<int> Anatomy::joints_of_no_finger() const {
  std::vector<int> result;
  for (int joint = 0; joint < model_.njnt; ++joint) {
    const int body = model_.jnt_bodyid[joint];
    if (is_below(body) && !carries_tip(body) && !is_in_finger(body)) result.push_back(joint);
  }
  return result;
}

std::vector<int> Anatomy::joints_before_fingers() const {
  std::vector<int> result;
  for (int joint = 0; joint < model_.njnt; ++joint) {
    const int body = model_.jnt_bodyid[joint];
    if (is_below(body) && carries_tip(body) && !is_in_finger(body)) result.push_back(joint);
  }
  return result;
}

bool Anatomy::is_below(int body, int above) const {
  while (body > above) body = model_.body_parentid[body];
  return body == above;
}

void refuse_slides(const mjModel& model, const Anatomy& anatomy) {
  int first = -1, slide = -1, hinges = 0, beyond = 0;
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (!anatomy.is_below(model.jnt_bodyid[joint])) continue;
    hinges += model.jnt_type[joint] == mjJNT_HINGE;
    if (model.jnt_type[joint] != mjJNT_SLIDE) continue;
    if (first < 0) first = joint;
    slide = joint;
  }
  if (slide < 0) return;
  const int body = model.jnt_bodyid[slide];
  for (int joint = 0; joint < model.njnt; ++joint) {
    beyond +=
        anatomy.is_below(model.jnt_bodyid[joint], body) && model.jnt_type[joint] == mjJNT_HINGE;
  }
  const bool carries = 2 * beyond > hinges;
  throw BadInput(fmt::format(
      "joint {} is a slide, and sliding joints are not supported{}",
      model_name(model, mjOBJ_JOINT, first),
      carries ? fmt::format("; if it only carries the hand, root = \"{}\" in a TOML file leaves it "
                            "out",
                            model_name(model, mjOBJ_BODY, body))
              : ""));
}

void shorten(std::vector<Chain>& fingers) {
  if (fingers.size() < 2) return;
  const std::string first = fingers.front().name;
  const auto end_of_all = [&](std::size_t length) {
    const auto ends_so = [&](const Chain& one) {
      return one.name.size() > length && one.name.ends_with(first.substr(first.size() - length));
    };
    return std::ranges::all_of(fingers, ends_so);
  };
  std::size_t length = 0;  // of what they all end in, from a separator on
  for (std::size_t i = 1; i < first.size() && end_of_all(i); ++i) {
    if (kSeparators.find(first[first.size() - i]) != std::string_view::npos) length = i;
  }
  for (Chain& one : fingers) {
    one.name.resize(one.name.size() - length);
    while (one.name.size() > 1 && kSeparators.find(one.name.back()) != std::string_view::npos) {
      one.name.pop_back();
    }
  }
}

}  // namespace palpate::simulation
