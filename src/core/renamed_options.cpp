// SPDX-License-Identifier: Apache-2.0
#include "core/renamed_options.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "palpate/core/options.hpp"

namespace palpate {
namespace {

using Rename = std::pair<std::string_view, std::string_view>;

constexpr Rename kMovedSection{"place.fingers.reorient.world.", "forward_model."};

constexpr std::string_view kFriction = "friction";
constexpr std::array<Rename, 11> kRenamedKeys{{
    {"track.look", "track.period"},
    {"place.again", "place.reestimate"},
    {"lift.way", "lift.height"},
    {"withdraw.way", "withdraw.distance"},
    {"place.withdraw.way", "place.withdraw.distance"},
    {"grasp.friction", kFriction},
    {"grasp.plan.friction", kFriction},
    {"palpation.friction", kFriction},
    {"place.transport.friction", kFriction},
    {"place.fingers.reorient.friction", kFriction},
    {"place.regrasp.plan.grasp.friction", kFriction},
}};

/// Parts of keys, between dots.
constexpr std::array<Rename, 50> kRenamedParts{{
    {"base", "mount"},
    {"base_jump", "mount_jump"},
    {"base_speed", "mount_speed"},
    {"base_acceleration", "mount_acceleration"},
    {"base_lead", "mount_lead"},
    {"felt", "tracking"},
    {"feel", "height_probe"},
    {"locate", "estimation"},
    {"probe", "palpation"},
    {"worth", "min_gain_rate"},
    {"least_information", "min_gain_rate"},
    {"means", "strategy"},
    {"stance", "stable_pose"},
    {"other_stance", "other_stable_pose"},
    {"felt_sigma", "probed_height_sigma"},
    {"swept_sigma", "free_space_sigma"},
    {"unfelt_force", "unsensed_force"},
    {"false_truth", "corrupted_truth"},
    {"twist", "torsional_friction_radius"},
    {"most_touches", "max_touches"},
    {"most_points", "max_points"},
    {"most_force", "max_force"},
    {"least_gap", "min_gap"},
    {"least_log_std", "min_log_std"},
    {"most", "max"},
    {"least", "min"},
    {"least_depth", "min_depth"},
    {"least_press", "min_press"},
    {"most_imbalance", "max_wrench_residual"},
    {"least_contacts", "min_contacts"},
    {"least_weight", "min_weight"},
    {"least_fingers", "min_fingers"},
    {"most_slip", "max_slip"},
    {"most_press", "max_press"},
    {"most_transfers", "max_transfers"},
    {"slip_way", "slip_distance"},
    {"way_speed", "linear_speed"},
    {"done_way", "done_distance"},
    {"drift_way", "drift_distance"},
    {"way_sigma", "translation_sigma"},
    {"turn_sigma", "rotation_sigma"},
    {"way_scale", "distance_scale"},
    {"least_force", "min_force"},
    {"least_ratio_rate", "min_ratio_rate"},
    {"least_speed", "min_speed"},
    {"least_spread", "min_spread"},
    {"least_share", "min_share"},
    {"least_concentration", "min_concentration"},
    {"noise_doubt", "noise_scale_prior"},
    {"size_doubt", "size_prior"},
}};

/// A key, or a section that ends with a dot, by its present name and without "expert.", and why it
/// is gone.
struct Removal {
  std::string_view key, reason;
};

constexpr std::string_view kPosture = "the postures are those of the hand's description";
constexpr std::string_view kUnread = "the forward model never used it";
constexpr std::string_view kExact = "the forward model has neither noise nor errors";
constexpr std::array<Removal, 29> kRemoved{{
    {"palpation.rolls", "a held object is no longer rolled between the fingers"},
    {"estimation.errors.link", "the hand's description has the errors of its links"},
    {"grasp.steep_pitch", kPosture},
    {"grasp.closing_angle", kPosture},
    // What holds of grasp.top does so of grasp.side.
    {"grasp.top.pitch", kPosture},
    {"grasp.top.roll", kPosture},
    {"grasp.top.offset_x", kPosture},
    {"grasp.top.offset_y", kPosture},
    {"grasp.top.height", kPosture},
    {"grasp.top.thumb_base", kPosture},
    {"grasp.top.thumb_opposition", kPosture},
    {"grasp.top.thumb_middle", kPosture},
    {"grasp.top.proximal", kPosture},
    {"grasp.top.distal", kPosture},
    {"grasp.top.spread", kPosture},
    {"grasp.top.little_base", kPosture},
    {"grasp.top.thumb_limit", kPosture},
    {"grasp.top.contact_torque.", kPosture},
    {"grasp.top.hold_torque.", kPosture},
    {"grasp.top.wait_for_all", kPosture},
    {"forward_model.hand", "the forward model is of the hand that the robot has"},
    {"forward_model.hand_friction", "the forward model has the friction that planning assumes"},
    {"forward_model.biotacs", kUnread},
    {"forward_model.second_object", "the forward model holds the object alone"},
    {"forward_model.corrupted_truth", kUnread},
    {"forward_model.integral.", "the forward model has no integral action"},
    {"forward_model.noise.", kExact},
    {"forward_model.error.", kExact},
    {"touch.height_probe.", "the object's stable pose is known in the relocate task"},
}};

std::string_view renamed_part(std::string_view part) {
  const auto* const found = std::find_if(kRenamedParts.begin(), kRenamedParts.end(),
                                         [&](const Rename& one) { return one.first == part; });
  return found == kRenamedParts.end() ? part : found->second;
}

}  // namespace

std::string renamed_option(std::string_view key) {
  std::string moved(key);
  if (key.starts_with(kMovedSection.first)) {
    moved = std::string(kMovedSection.second).append(key.substr(kMovedSection.first.size()));
  }
  std::string result;
  for (std::size_t start = 0; start <= moved.size();) {
    const std::size_t end = std::min(moved.find('.', start), moved.size());
    result.append(result.empty() ? "" : ".")
        .append(renamed_part(std::string_view(moved).substr(start, end - start)));
    start = end + 1;
  }
  const auto* const whole = std::ranges::find(kRenamedKeys, result, &Rename::first);
  return whole == kRenamedKeys.end() ? result : std::string(whole->second);
}

std::string_view removed_option(std::string_view key) {
  if (key.starts_with(kExpertSection)) key.remove_prefix(kExpertSection.size());
  constexpr std::string_view kSide = "grasp.side.", kTop = "grasp.top.";
  std::string present = renamed_option(key);
  if (present.starts_with(kSide)) present.replace(0, kSide.size(), kTop);
  const auto* const found = std::ranges::find_if(kRemoved, [&](const Removal& one) {
    return one.key.ends_with('.') ? present.starts_with(one.key) : present == one.key;
  });
  return found == kRemoved.end() ? std::string_view() : found->reason;
}

}  // namespace palpate
