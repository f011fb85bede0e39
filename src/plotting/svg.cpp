// SPDX-License-Identifier: Apache-2.0
#include "plotting/svg.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::plotting {
namespace {

/// Length of the well-formed UTF-8 character at the start of the text, 0 if there is none
/// (Unicode 15, table 3-7).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (length == 0 || first > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool overlong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool outside = (first == 0xed && byte(1) > 0x9f) || (first == 0xf4 && byte(1) > 0x8f);
  return overlong || outside ? 0 : length;
}

std::string_view entity(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    default:
      return {};
  }
}

std::string point_list(const std::vector<SvgBody::Point>& points) {
  std::string list;
  for (const auto& p : points) {
    list += fmt::format("{}{:.2f},{:.2f}", list.empty() ? "" : " ", p.x(), p.y());
  }
  return list;
}

}  // namespace

std::size_t character_count(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) >> 6) != 2; }));
}

std::string xml_text(std::string_view text) {
  constexpr std::string_view kReplacement = "\xef\xbf\xbd";  // U+FFFD
  std::string result;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    if (length == 1 && static_cast<unsigned char>(text[0]) < 0x20) {
      result += ' ';
    } else if (const auto escaped = entity(text[0]); !escaped.empty()) {
      result += escaped;
    } else {
      result += length == 0 ? kReplacement : character;
    }
    text.remove_prefix(character.size());
  }
  return result;
}

void SvgBody::raw(std::string_view element) {
  text_ += element;
  text_ += '\n';
}

void SvgBody::line(const Point& a, const Point& b, std::string_view style) {
  raw(fmt::format(R"(<line x1="{:.2f}" y1="{:.2f}" x2="{:.2f}" y2="{:.2f}" {}/>)", a.x(), a.y(),
                  b.x(), b.y(), style));
}

void SvgBody::polyline(const std::vector<Point>& points, std::string_view style) {
  raw(fmt::format(R"(<polyline points="{}" fill="none" {}/>)", point_list(points), style));
}

void SvgBody::polygon(const std::vector<Point>& points, std::string_view style) {
  raw(fmt::format(R"(<polygon points="{}" {}/>)", point_list(points), style));
}

void SvgBody::rectangle(const Point& a, const Point& b, std::string_view style) {
  const Point corner = a.cwiseMin(b), size = (b - a).cwiseAbs();
  raw(fmt::format(R"(<rect x="{:.2f}" y="{:.2f}" width="{:.2f}" height="{:.2f}" {}/>)", corner.x(),
                  corner.y(), size.x(), size.y(), style));
}

void SvgBody::circle(const Point& center, double radius, std::string_view style) {
  raw(fmt::format(R"(<circle cx="{:.2f}" cy="{:.2f}" r="{:.2f}" {}/>)", center.x(), center.y(),
                  radius, style));
}

void SvgBody::text(const Point& at, std::string_view text, std::string_view style) {
  raw(fmt::format(R"(<text x="{:.2f}" y="{:.2f}" {}>{}</text>)", at.x(), at.y(), style,
                  xml_text(text)));
}

void SvgBody::rotated_text(const Point& at, double degrees, std::string_view text,
                           std::string_view style) {
  raw(fmt::format("<text transform=\"translate({:.2f} {:.2f}) rotate({:.0f})\" {}>{}</text>",
                  at.x(), at.y(), degrees, style, xml_text(text)));
}

}  // namespace palpate::plotting
