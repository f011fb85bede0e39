// SPDX-License-Identifier: Apache-2.0
#include "replay_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common.hpp"
#include "palpate/core/error.hpp"

namespace palpate::app {
namespace {

using evaluation::TrialOptions;

/// Whole sections end with a dot. What distinguishes one object from others is read where there are
/// others.
constexpr std::array<std::string_view, 11> kRead = {"estimation.",
                                                    "expert.estimation.",
                                                    "expert.calibrate.rest",
                                                    "expert.calibrate.sigma",
                                                    "expert.calibrate.mount",
                                                    "expert.calibrate.mount_angle",
                                                    "expert.calibrate.table_height",
                                                    "expert.calibrate.table_tilt",
                                                    "start.uncertainty",
                                                    "expert.start.x",
                                                    "expert.start.y"};
constexpr std::array<std::string_view, 3> kReadWithBiotacs = {
    "touch.biotac_point", "touch.biotac_normal", "touch.biotac_false"};
constexpr std::string_view kOfSeveralObjects = "expert.estimation.identify.";

bool names(std::string_view known, std::string_view key) {
  return known.ends_with('.') ? key.starts_with(known) : key == known;
}

}  // namespace

bool is_read_by_replay(std::string_view key, const TrialOptions& options) {
  const auto named = [key](std::string_view known) { return names(known, key); };
  if (named(kOfSeveralObjects)) return false;
  if (std::ranges::any_of(kRead, named)) return true;
  return options.touch.from_biotacs() && std::ranges::any_of(kReadWithBiotacs, named);
}

void refuse_what_is_recorded(const TrialOptions& recorded, const TrialOptions& asked,
                             const std::string& recording) {
  const auto before = list_options(recorded), now = list_options(asked);
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (now[i].value == before[i].value || is_read_by_replay(now[i].key, recorded)) continue;
    throw BadInput(fmt::format(
        "{} = {}: {} was recorded with {}, and a replay does not change what was done and sensed; "
        "palpate options replay lists what it reads",
        now[i].key, now[i].value, recording, before[i].value));
  }
}

std::vector<OptionInfo> replay_option_list() {
  TrialOptions options;
  options.touch.source = "biotac";  // with which it reads the most
  auto list = list_options(TrialOptions{});
  std::erase_if(list, [&](const OptionInfo& o) { return !is_read_by_replay(o.key, options); });
  return list;
}

}  // namespace palpate::app
