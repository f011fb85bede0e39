// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/anatomy.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

int joints_below(mjsBody& body) {
  int count = 0;
  for (mjsElement* e = mjs_firstChild(&body, mjOBJ_JOINT, 1); e; e = mjs_nextChild(&body, e, 1)) {
    ++count;
  }
  return count;
}

}  // namespace

std::vector<std::string> listed(std::string_view names) {
  std::vector<std::string> list;
  if (names.empty()) return list;
  for (const std::string_view name : csv_cells(names)) list.emplace_back(name);
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

void free_from_joints(mjSpec& spec, const std::string& root) {
  mjsBody& body = find_body(spec, root);
  while (mjsElement* joint = mjs_firstChild(&body, mjOBJ_JOINT, 0)) mjs_delete(&spec, joint);
}

Anatomy::Anatomy(const mjModel& model, const std::string& root, const HandNotes& notes)
    : model_(model), root_(find_id(model, mjOBJ_BODY, root)) {
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

void Anatomy::find_fingers(const HandNotes& notes) {
  for (const int child : children(palm_)) {
    if (joints_in(child) == 0) continue;
    Chain chain;
    chain.bodies = longest_chain(child);
    if (chain.bodies.empty()) continue;
    chain.tip = chain.bodies.back();
    fingers_.push_back(chain);
  }
  choose_tips(notes);
  const auto names = listed(notes.fingers);
  if (!names.empty() && names.size() != fingers_.size()) {
    throw BadInput(fmt::format("fingers = '{}' names {} fingers, but the hand has {}",
                               notes.fingers, names.size(), fingers_.size()));
  }
  for (std::size_t i = 0; i < fingers_.size(); ++i) {
    fingers_[i].name = names.empty() ? model_name(model_, mjOBJ_BODY, fingers_[i].tip) : names[i];
  }
}

void Anatomy::choose_tips(const HandNotes& notes) {
  if (notes.tips.empty()) return;
  std::vector<Chain> chosen;
  for (const std::string& name : listed(notes.tips)) {
    Chain chain;
    chain.tip = find_id(model_, mjOBJ_BODY, name);
    if (!is_below(chain.tip)) {
      throw BadInput(fmt::format("the fingertip {} is not below the hand's root {}", name,
                                 model_name(model_, mjOBJ_BODY, root_)));
    }
    for (int body = chain.tip; body > 0 && body != palm_; body = model_.body_parentid[body]) {
      chain.bodies.insert(chain.bodies.begin(), body);
    }
    chosen.push_back(chain);
  }
  fingers_ = chosen;
}

bool Anatomy::is_below(int body) const {
  while (body > root_) body = model_.body_parentid[body];
  return body == root_;
}

void shorten(std::vector<Chain>& fingers) {
  if (fingers.size() < 2) return;
  const auto all = [&](auto&& test) { return std::all_of(fingers.begin(), fingers.end(), test); };
  std::string& first = fingers.front().name;
  while (first.size() > 1 && all([&](const Chain& one) {
           return one.name.size() > 1 && one.name.back() == first.back();
         })) {
    for (Chain& one : fingers) one.name.pop_back();
  }
  for (Chain& one : fingers) {
    while (one.name.size() > 1 && (one.name.back() == '_' || one.name.back() == '-')) {
      one.name.pop_back();
    }
  }
}

}  // namespace palpate::simulation
