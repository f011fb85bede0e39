// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/load_hand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/options.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/grasping/derive_postures.hpp"
#include "palpate/simulation/hand/hand_store.hpp"

namespace palpate::simulation {
namespace {

constexpr const char* kShadowRight = "shadow_hand/right_hand.xml";
constexpr const char* kShadowLeft = "shadow_hand/left_hand.xml";

std::filesystem::path file_of(const std::string& name) {
  if (auto installed = installed_hand(name); !installed.empty()) return installed;
  const auto stored = stored_hands();
  const bool known = std::any_of(stored.begin(), stored.end(),
                                 [&](const StoredHand& one) { return one.name == name; });
  if (known) {
    throw BadInput(
        fmt::format("the hand {0} is not installed: run palpate hand install {0}", name));
  }
  std::error_code error;
  if (!std::filesystem::exists(name, error)) {
    if (std::ranges::count(stored_arms(), name, &StoredHand::name) > 0) {
      throw BadInput(fmt::format("{0} is an arm, not a hand: pick --arm {0}", name));
    }
    std::vector<std::string> names{"shadow", "shadow-left"};
    for (const StoredHand& one : stored) names.push_back(one.name);
    throw BadInput(
        fmt::format("'{}' is neither a hand of `palpate hand list` nor a file that exists{}", name,
                    did_you_mean(name, names)));
  }
  return name;
}

bool is_toml(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".toml" || extension == ".TOML";
}

/// A hand of a model file, or of a TOML file that names one.
DescribedHand describe(const std::filesystem::path& file) {
  HandNotes notes;
  if (!is_toml(file)) return describe_hand(file, notes);
  load_toml(file, notes);
  if (notes.model.empty()) {
    throw BadInput(
        fmt::format("{}: model = \"FILE\" is missing: the hand's MJCF or URDF", file.string()));
  }
  if (is_toml(notes.model)) {
    throw BadInput(fmt::format("{}: model = \"{}\" is a TOML file, not the hand's MJCF or URDF",
                               file.string(), notes.model));
  }
  try {
    return describe_hand(file.parent_path() / notes.model, notes);
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", file.string(), error.what()));
  }
}

/// Where there are none: the reason, with the file.
void derive_postures(const std::filesystem::path& file, DescribedHand& hand,
                     const ProgressCallback& progress) {
  try {
    grasping::derive_postures(hand.hand, progress);
  } catch (const BadInput& error) {
    hand.hand.postures = {};
    hand.failure = fmt::format("{}: {}", file.string(), error.what());
  }
}

}  // namespace

DescribedHand load_described_hand(const std::string& name, double stiffness_scale,
                                  const ProgressCallback& progress) {
  if (name.empty() || name == "shadow" || name == "shadow-left") {
    const char* file = name == "shadow-left" ? kShadowLeft : kShadowRight;
    DescribedHand shadow{load_shadow_hand(asset(file), stiffness_scale), {}, {}, {}};
    if (!name.empty()) shadow.hand.name = name;
    return shadow;
  }
  static std::mutex mutex;
  static std::map<std::string, DescribedHand> loaded;
  const std::scoped_lock lock(mutex);
  const auto known = loaded.find(name);
  if (known != loaded.end()) return known->second;
  const auto file = file_of(name);
  DescribedHand hand = describe(file);
  hand.hand.name = name;
  derive_postures(file, hand, progress);
  if (!hand.failure.empty()) return hand;  // its file may be corrected meanwhile
  return loaded.emplace(name, std::move(hand)).first->second;
}

hand::Description load_hand(const std::string& name, double stiffness_scale) {
  DescribedHand loaded = load_described_hand(name, stiffness_scale);
  if (!loaded.failure.empty()) {
    throw BadInput(loaded.failure + "; `palpate hand check` shows what was derived");
  }
  return std::move(loaded.hand);
}

}  // namespace palpate::simulation
