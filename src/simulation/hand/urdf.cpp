// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/urdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <charconv>
#include <cmath>
#include <functional>
#include <set>
#include <sstream>
#include <string_view>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "simulation/hand/xml_tags.hpp"

namespace palpate::simulation {
namespace {

namespace xml = boost::property_tree;

constexpr std::size_t kMaxMimics = 200;
constexpr const char* kAttributes = "<xmlattr>";

std::string attribute(const xml::ptree& element, const std::string& name,
                      const std::string& usual = "") {
  return element.get(std::string(kAttributes) + "." + name, usual);
}

/// A number of a joint's mimic tag.
double number(const std::string& joint, const xml::ptree& mimic, const std::string& name,
              const std::string& usual) {
  const std::string text = attribute(mimic, name, usual);
  std::string_view digits = trimmed(text);
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) {
    throw BadInput(
        fmt::format("the mimic of joint {}: {}='{:.60}' is no finite number", joint, name, text));
  }
  return value;
}

/// @throws BadInput if two of the robot's links, or two of its joints, have one name
void refuse_twins(const xml::ptree& robot) {
  std::set<std::pair<std::string, std::string>> known;
  for (const auto& [kind, element] : robot) {
    if (kind != "link" && kind != "joint") continue;
    const std::string name = attribute(element, "name");
    if (name.empty()) throw BadInput(fmt::format("a {} has no name", kind));
    if (known.emplace(kind, name).second) continue;
    throw BadInput(fmt::format("two {}s are named '{}'", kind, name));
  }
}

/// @throws BadInput if a link is below itself
void refuse_circles(const xml::ptree& robot) {
  std::map<std::string, std::string> above;
  for (const auto& [kind, element] : robot) {
    if (kind != "joint") continue;
    const std::string child = element.get("child.<xmlattr>.link", "");
    if (!child.empty()) above.emplace(child, element.get("parent.<xmlattr>.link", ""));
  }
  for (const auto& [link, parent] : above) {
    std::size_t steps = 0;
    for (auto up = above.find(parent); up != above.end(); up = above.find(up->second)) {
      if (up->first == link || ++steps > above.size()) {
        throw BadInput(fmt::format("link '{}' is below itself: its joints form a circle", link));
      }
    }
  }
}

/// A bound that is not given is 0, by the format's definition.
void complete_limits(xml::ptree& joint) {
  const auto limit = joint.find("limit");
  if (limit == joint.not_found()) return;
  const bool low = !attribute(limit->second, "lower").empty();
  const bool high = !attribute(limit->second, "upper").empty();
  if (low == high) return;
  limit->second.put(std::string(kAttributes) + (low ? ".upper" : ".lower"), "0");
}

std::vector<MimicJoint> read_mimics(const xml::ptree& robot) {
  std::vector<MimicJoint> mimics;
  for (const auto& [kind, joint] : robot) {
    if (kind != "joint") continue;
    const auto mimic = joint.find("mimic");
    if (mimic == joint.not_found()) continue;
    if (mimics.size() >= kMaxMimics) {
      throw BadInput(fmt::format("more than {} mimic joints", kMaxMimics));
    }
    const xml::ptree& tag = mimic->second;
    const std::string name = attribute(joint, "name");
    mimics.push_back({name, attribute(tag, "joint"), number(name, tag, "multiplier", "1"),
                      number(name, tag, "offset", "0")});
  }
  return mimics;
}

/// Calls a function with each mesh of a link's shapes.
void for_each_mesh(xml::ptree& robot, const std::function<void(xml::ptree&)>& function) {
  for (auto& [kind, link] : robot) {
    if (kind != "link") continue;
    for (auto& [part, shape] : link) {
      if (part != "visual" && part != "collision") continue;
      const auto mesh = shape.get_child_optional("geometry.mesh");
      if (mesh) function(*mesh);
    }
  }
}

std::string stem(const std::string& file) { return std::filesystem::path(file).stem().string(); }

/// The simulator names meshes by their files, without folder and extension, and those of a second
/// scale by a number at the end. Of meshes that differ in file or scale, all but the first that
/// would have a name get names of their own.
/// @return files, by these names
std::map<std::string, std::string> name_meshes_uniquely(xml::ptree& robot) {
  using Mesh = std::pair<std::string, std::string>;  // file, scale
  const auto mesh_of = [](const xml::ptree& mesh) {
    return Mesh(attribute(mesh, "filename"), attribute(mesh, "scale"));
  };
  std::vector<Mesh> meshes;
  std::set<std::string> stems;
  for_each_mesh(robot, [&](xml::ptree& mesh) {
    meshes.push_back(mesh_of(mesh));
    stems.insert(stem(meshes.back().first));
  });
  std::map<Mesh, std::string> names;
  std::map<std::string, std::string> renamed;
  std::set<std::string> taken;
  for (const Mesh& mesh : meshes) {
    if (names.contains(mesh)) continue;
    std::string name = stem(mesh.first);
    for (int count = 2; taken.contains(name); ++count) {
      const std::string other = fmt::format("{}_{}", stem(mesh.first), count);
      if (!stems.contains(other)) name = other;
    }
    taken.insert(name);
    names[mesh] = name;
    if (name != stem(mesh.first)) renamed[name] = mesh.first;
  }
  for_each_mesh(robot, [&](xml::ptree& mesh) {
    const auto& [file, scale] = mesh_of(mesh);
    const std::string& name = names.at({file, scale});
    if (name == stem(file)) return;
    mesh.put(std::string(kAttributes) + ".filename",
             name + std::filesystem::path(file).extension().string());
  });
  return renamed;
}

}  // namespace

bool is_urdf(const std::filesystem::path& file) {
  std::string first;
  const std::string text = read_file(file);
  for_each_tag(text, [&](std::string_view tag) {
    if (first.empty() && !tag.starts_with('?') && !tag.starts_with('!')) {
      first = tag.substr(0, tag.find_first_of(" \t\r\n/"));
    }
  });
  return first == "robot";
}

Urdf read_urdf(const std::filesystem::path& file) {
  std::istringstream in(read_file(file));
  xml::ptree document;
  try {
    xml::read_xml(in, document, xml::xml_parser::no_comments);
  } catch (const xml::xml_parser_error& error) {
    throw BadInput(fmt::format("it is not XML, from line {} on", error.line()));
  }
  const auto robot = document.find("robot");
  if (robot == document.not_found()) throw BadInput("it has no element <robot>");
  refuse_twins(robot->second);
  refuse_circles(robot->second);
  for (auto& [kind, element] : robot->second) {
    if (kind != "joint") continue;
    complete_limits(element);
    if (attribute(element, "type") == "fixed") element.erase("mimic");
  }
  Urdf urdf;
  urdf.mimics = read_mimics(robot->second);
  urdf.meshes = name_meshes_uniquely(robot->second);
  std::ostringstream out;
  xml::write_xml(out, document);
  urdf.text = out.str();
  return urdf;
}

}  // namespace palpate::simulation
