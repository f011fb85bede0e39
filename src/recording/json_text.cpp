// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/json_text.hpp"

#include <fmt/format.h>

#include "palpate/core/error.hpp"

namespace palpate::recording {

using nlohmann::json;

json parse_json(std::string_view text) {
  const auto check_depth = [](int depth, json::parse_event_t event, json&) {
    const bool opens =
        event == json::parse_event_t::array_start || event == json::parse_event_t::object_start;
    if (opens && depth >= kMaxJsonDepth) {  // of what it stands in
      throw BadInput(fmt::format("JSON that nests deeper than {} levels", kMaxJsonDepth));
    }
    return true;
  };
  try {
    return json::parse(text, check_depth);
  } catch (const json::exception& error) {
    const std::string what = error.what();  // "[json.exception...] parse error at line 1, ..."
    const auto place = what.find("line ");
    throw BadInput(fmt::format("not JSON: {}", place == what.npos ? what : what.substr(place)));
  }
}

std::string shown(const json& value) {
  constexpr std::size_t kMost = 60;
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > kMost) text = text.substr(0, kMost) + "...";
  return text;
}

}  // namespace palpate::recording
