// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/mimic_joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::simulation {
namespace {

std::vector<MimicJoint> of_equalities(const mjModel& model) {
  std::vector<MimicJoint> mimics;
  for (int i = 0; i < model.neq; ++i) {
    if (model.eq_type[i] != mjEQ_JOINT || model.eq_obj2id[i] < 0) continue;
    const mjtNum* const data = model.eq_data + mjNEQDATA * i;  // polynomial of the leader's angle
    mimics.push_back({mj_id2name(&model, mjOBJ_JOINT, model.eq_obj1id[i]),
                      mj_id2name(&model, mjOBJ_JOINT, model.eq_obj2id[i]), data[1], data[0]});
  }
  return mimics;
}

std::string attribute(const std::string& tag, const std::string& name, const std::string& usual) {
  std::smatch found;
  const std::regex pattern("\\b" + name + "\\s*=\\s*[\"']([^\"']*)[\"']");
  return std::regex_search(tag, found, pattern) ? found[1].str() : usual;
}

double number(const std::string& tag, const std::string& name, const std::string& usual) {
  const std::string text = attribute(tag, name, usual);
  try {
    return std::stod(text);
  } catch (const std::exception&) {
    throw BadInput(fmt::format("mimic: {}='{}' is no number", name, text));
  }
}

std::vector<MimicJoint> of_urdf(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  std::vector<MimicJoint> mimics;
  const std::regex joint("<joint\\s[^>]*>");
  const std::regex mimic("<mimic\\s[^>]*>");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), joint);
       it != std::sregex_iterator(); ++it) {
    const auto begin = text.begin() + it->position();
    const auto close = text.find("</joint>", static_cast<std::size_t>(it->position()));
    if (close == std::string::npos) continue;
    const std::string body(begin, text.begin() + static_cast<std::ptrdiff_t>(close));
    std::smatch found;
    if (!std::regex_search(body, found, mimic)) continue;
    const std::string tag = found[0].str();
    mimics.push_back({attribute(it->str(), "name", ""), attribute(tag, "joint", ""),
                      number(tag, "multiplier", "1"), number(tag, "offset", "0")});
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
