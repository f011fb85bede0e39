// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/xml_tags.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include "palpate/core/error.hpp"

namespace palpate::simulation {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr int kDeepest = 400;  // elements within one another
constexpr int kMostBodies = 5000;
constexpr double kMostOfAll = 10000;  // of what an attribute counts

/// Attributes that say how many there are of something.
constexpr std::array<std::string_view, 3> kCounts = {"count", "nrow", "ncol"};

/// Attributes of MJCF and URDF that place things or say what they are like.
constexpr std::array<std::string_view, 32> kNumbers = {
    "pos",  "quat",        "euler",       "axisangle", "xyaxes", "zaxis",  "fromto",   "size",
    "mass", "diaginertia", "fullinertia", "density",   "axis",   "range",  "ref",      "scale",
    "xyz",  "rpy",         "value",       "ixx",       "iyy",    "izz",    "ixy",      "ixz",
    "iyz",  "lower",       "upper",       "radius",    "length", "offset", "polycoef", "armature"};

bool is_blank(char c) { return kBlanks.find(c) != std::string_view::npos; }

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

/// Where what begins here with one mark ends with another; `at` itself if it begins otherwise.
std::size_t skipped(std::string_view text, std::size_t at, std::string_view begin,
                    std::string_view end) {
  if (!text.substr(at).starts_with(begin)) return at;
  const std::size_t found = text.find(end, at + begin.size());
  return found == std::string_view::npos ? text.size() : found + end.size();
}

/// Limits may be infinite.
constexpr std::array<std::string_view, 3> kLimits = {"range", "lower", "upper"};

/// Whether one of the numbers in an attribute is NaN, or infinite where that is no limit.
bool is_broken(std::string_view name, std::string_view value) {
  const bool limit = std::ranges::find(kLimits, name) != kLimits.end();
  while (true) {
    const std::size_t begin = value.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return false;
    value.remove_prefix(begin);
    const std::string word(value.substr(0, value.find_first_of(kBlanks)));
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end == 0 && (limit ? std::isnan(number) : !std::isfinite(number))) return true;
    value.remove_prefix(word.size());
  }
}

}  // namespace

void for_each_tag(std::string_view text, const std::function<void(std::string_view)>& function) {
  for (std::size_t at = text.find('<'); at < text.size(); at = text.find('<', at)) {
    const std::size_t past =
        std::max(skipped(text, at, "<!--", "-->"), skipped(text, at, "<![CDATA[", "]]>"));
    if (past != at) {
      at = past;
      continue;
    }
    const std::size_t end = end_of_tag(text, at);
    function(text.substr(at + 1, end - at - 1));
    at = end;
  }
}

void for_each_attribute(
    std::string_view tag,
    const std::function<void(std::string_view name, std::string_view value)>& function) {
  for (std::size_t equals = tag.find('='); equals < tag.size(); equals = tag.find('=', equals)) {
    std::size_t end = equals;
    while (end > 0 && is_blank(tag[end - 1])) --end;
    std::size_t begin = end;
    while (begin > 0 && !is_blank(tag[begin - 1])) --begin;
    const std::size_t open = tag.find_first_not_of(kBlanks, equals + 1);
    if (open == std::string_view::npos || (tag[open] != '"' && tag[open] != '\'')) return;
    const std::size_t close = tag.find(tag[open], open + 1);
    if (close == std::string_view::npos) return;
    function(tag.substr(begin, end - begin), tag.substr(open + 1, close - open - 1));
    equals = close;
  }
}

void check_text(std::string_view text) {
  int depth = 0, bodies = 0;
  for_each_tag(text, [&](std::string_view tag) {
    if (tag.starts_with("xacro:")) {
      throw BadInput("it holds xacro macros; run xacro on it first, and give what that writes");
    }
    const std::string_view element = tag.substr(0, tag.find_first_of(" \t\r\n/", 1));
    for_each_attribute(tag, [&](std::string_view name, std::string_view value) {
      if (value.find("${") != value.npos) {
        throw BadInput("it holds xacro macros; run xacro on it first, and give what that writes");
      }
      if (std::ranges::find(kCounts, name) != kCounts.end() &&
          std::strtod(std::string(value).c_str(), nullptr) > kMostOfAll) {
        throw BadInput(fmt::format("{}=\"{:.60}\" is more than {}", name, value, kMostOfAll));
      }
      if (std::ranges::find(kNumbers, name) == kNumbers.end() || !is_broken(name, value)) return;
      throw BadInput(fmt::format("line {}: <{} {}=\"{:.60}\"> is not finite",
                                 1 + std::count(text.data(), tag.data(), '\n'), element, name,
                                 value));
    });
    if (tag.starts_with('?') || tag.starts_with('!')) return;
    bodies += element == "body" || element == "link";
    if (bodies > kMostBodies) {
      throw BadInput(fmt::format("it has more than {} bodies", kMostBodies));
    }
    depth += tag.starts_with('/') ? -1 : tag.ends_with('/') ? 0 : 1;
    if (depth > kDeepest) {
      throw BadInput(fmt::format("its elements are nested more than {} deep", kDeepest));
    }
  });
}

}  // namespace palpate::simulation
