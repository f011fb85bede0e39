// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/mimic_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::simulation {
namespace {

std::vector<MimicJoint> of_equalities(const mjModel& model) {
  std::vector<MimicJoint> mimics;
  for (int i = 0; i < model.neq; ++i) {
    if (model.eq_type[i] != mjEQ_JOINT || model.eq_obj2id[i] < 0 || !model.eq_active0[i]) continue;
    const int follower = model.eq_obj1id[i], leader = model.eq_obj2id[i];
    const std::string name = mj_id2name(&model, mjOBJ_JOINT, follower);
    const mjtNum* const data = model.eq_data + mjNEQDATA * i;  // polynomial of the leader's way
    if (data[2] != 0 || data[3] != 0 || data[4] != 0) {
      throw BadInput(
          fmt::format("the equality of joint {} is no linear one (polycoef {} {} {} {} {})", name,
                      data[0], data[1], data[2], data[3], data[4]));
    }
    if (std::ranges::find(mimics, name, &MimicJoint::joint) != mimics.end()) {
      throw BadInput(fmt::format("joint {} follows two others by equalities", name));
    }
    const auto drawn_at = [&](int joint) { return model.qpos0[model.jnt_qposadr[joint]]; };
    mimics.push_back({name, mj_id2name(&model, mjOBJ_JOINT, leader), data[1],
                      data[0] + drawn_at(follower) - data[1] * drawn_at(leader)});
  }
  return mimics;
}

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::size_t kMaxMimics = 200;

bool is_blank(char c) { return kBlanks.find(c) != std::string_view::npos; }

/// The value of an attribute in a tag's text, quotes taken off.
std::string attribute(std::string_view tag, std::string_view name, std::string_view usual) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos;
       at = tag.find(name, at + name.size())) {
    const std::size_t equals = tag.find_first_not_of(kBlanks, at + name.size());
    if (at == 0 || !is_blank(tag[at - 1]) || equals >= tag.size() || tag[equals] != '=') continue;
    const std::size_t open = tag.find_first_not_of(kBlanks, equals + 1);
    if (open >= tag.size() || (tag[open] != '"' && tag[open] != '\'')) continue;
    const std::size_t close = tag.find(tag[open], open + 1);
    if (close != std::string_view::npos) return std::string(tag.substr(open + 1, close - open - 1));
  }
  return std::string(usual);
}

double number(std::string_view tag, std::string_view name, std::string_view usual) {
  const std::string text = attribute(tag, name, usual);
  std::string_view digits = trimmed(text);
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
    throw BadInput(fmt::format("mimic: {}='{:.60}' is no finite number", name, text));
  }
  return value;
}

/// End of a tag that begins at `at`: of its '>', which may also stand between quotes.
std::size_t end_of_tag(std::string_view text, std::size_t at) {
  char quote = 0;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return at;
    }
  }
  return text.size();
}

/// Calls a function with each tag of an XML text, without its brackets. Comments are left out.
template <class Function>
void for_each_tag(std::string_view text, const Function& function) {
  constexpr std::string_view kComment = "<!--", kCommentEnd = "-->";
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    if (text.substr(at, kComment.size()) == kComment) {
      at = std::min(text.find(kCommentEnd, at + kComment.size()), text.size());
      continue;
    }
    const std::size_t end = end_of_tag(text, at);
    function(text.substr(at + 1, end - at - 1));
    at = end;
  }
}

std::vector<MimicJoint> of_urdf(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  std::vector<MimicJoint> mimics;
  std::string joint;
  for_each_tag(text, [&](std::string_view tag) {
    const std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/", 1));
    if (name == "joint") joint = tag.ends_with('/') ? "" : attribute(tag, "name", "");
    if (name == "/joint") joint.clear();
    if (name != "mimic" || joint.empty()) return;
    if (mimics.size() >= kMaxMimics) {
      throw BadInput(fmt::format("{}: more than {} mimic joints", file.string(), kMaxMimics));
    }
    mimics.push_back({joint, attribute(tag, "joint", ""), number(tag, "multiplier", "1"),
                      number(tag, "offset", "0")});
  });
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

std::vector<MimicJoint> mimic_joints(const mjModel& model, const std::filesystem::path& file) {
  // Of a URDF the simulator leaves out mimics that it does not understand.
  auto mimics = file.extension() == ".urdf" ? of_urdf(file) : of_equalities(model);
  resolve(mimics);
  for (const MimicJoint& mimic : mimics) {
    if (mj_name2id(&model, mjOBJ_JOINT, mimic.leader.c_str()) >= 0) continue;
    throw BadInput(
        fmt::format("joint {} follows {}, which the hand lacks", mimic.joint, mimic.leader));
  }
  return mimics;
}

}  // namespace palpate::simulation
