// SPDX-License-Identifier: Apache-2.0
#include "fingerprint.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "palpate/core/cache.hpp"
#include "palpate/core/file.hpp"
#include "palpate/simulation/hand/load_arm.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Texts one after the other are the same only where each is.
std::string delimited(const std::string& text) { return fmt::format("{}:{}\n", text.size(), text); }

std::string text_of(const char* kind, const std::vector<NamedObject>& objects) {
  std::string text;
  for (const auto& [name, object] : objects) {
    text += fmt::format("{} {}{}\n", kind, delimited(name), object->mass);
    text += delimited(bytes_of(object->mesh.vertices));
    text += delimited(bytes_of(object->mesh.triangles));
  }
  return text;
}

/// What the files of the hand, its model and the arm hold, wherever they are.
std::string text_of_robot(const simulation::WorldOptions& world) {
  const hand::Description hand = simulation::load_hand(world.hand);
  std::set<fs::path> files = {hand.file.path};
  if (const auto arm = simulation::load_arm(world.arm, hand)) files.insert(arm->file.path);
  std::error_code error;
  if (fs::is_regular_file(world.hand, error)) files.insert(world.hand);
  std::set<std::string> contents;
  for (const fs::path& file : files) {
    if (fs::is_regular_file(file, error)) contents.insert(content_hash(read_file(file)));
  }
  std::string text;
  for (const std::string& content : contents) text += delimited(content);
  return text;
}

}  // namespace

std::string trials_fingerprint(const CommonOptions& common, const evaluation::TrialOptions& options,
                               const std::vector<NamedObject>& objects,
                               const std::vector<NamedObject>& candidates) {
  return content_hash(config_header(common) + to_toml(options) + text_of("object", objects) +
                      text_of("candidate", candidates) + text_of_robot(options.world));
}

}  // namespace palpate::app
