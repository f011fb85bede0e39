// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::plotting {

/// Number of characters of a UTF-8 text.
std::size_t character_count(std::string_view text);

/// Text that may stand in an XML document: markup escaped, bytes that XML forbids replaced.
std::string xml_text(std::string_view text);

/// Elements of an SVG picture, one a line; positions in px, y downwards. `style` holds attributes.
class SvgBody {
 public:
  using Point = Eigen::Vector2d;

  void line(const Point& a, const Point& b, std::string_view style);
  void polyline(const std::vector<Point>& points, std::string_view style);
  void polygon(const std::vector<Point>& points, std::string_view style);
  void rectangle(const Point& a, const Point& b, std::string_view style);  ///< opposite corners
  void circle(const Point& center, double radius, std::string_view style);
  void text(const Point& at, std::string_view text, std::string_view style);
  void rotated_text(const Point& at, double degrees, std::string_view text, std::string_view style);
  void raw(std::string_view element);

  const std::string& str() const { return text_; }

 private:
  std::string text_;
};

}  // namespace palpate::plotting
