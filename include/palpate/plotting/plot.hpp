// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace palpate::plotting {

/// One axis of a plot. A limit that is not given follows the data.
struct PlotAxis {
  std::string label;  ///< with the unit, as in "angle error (deg)"
  bool logarithmic = false;
  std::optional<double> low{}, high{};
};

/// Points joined in their order; the line breaks where a value cannot be drawn.
struct LineSeries {
  std::string name;  ///< for the legend; an empty name stays out of it (all series)
  std::vector<double> x, y;
};

struct ScatterSeries {
  std::string name;
  std::vector<double> x, y;
};

/// One bar a category.
struct BarSeries {
  std::string name;
  std::vector<double> values;
};

/// One box a category: quartiles and median; whiskers to the furthest sample within 1.5 times the
/// interquartile range, samples beyond as points (Tukey 1977).
struct BoxSeries {
  std::string name;
  std::vector<std::vector<double>> samples;
};

using PlotSeries = std::variant<LineSeries, ScatterSeries, BarSeries, BoxSeries>;

/// What a plot shows.
struct Plot {
  std::string title;
  PlotAxis x, y;
  /// Names along x, at 0, 1, 2, ...; bars and boxes need them. Empty: x is an axis of numbers.
  std::vector<std::string> categories{};
  std::vector<PlotSeries> series{};
  int width = 720, height = 440;  ///< px
};

/// Text of an SVG 1.1 picture of the plot, in a palette that colour-blind readers can tell apart
/// (Okabe & Ito 2008). The same plot gives the same text.
///
/// Values that are not finite, and those below or at 0 on a logarithmic axis, are left out.
/// @throws BadInput if there is nothing to draw, lengths differ, bars or boxes lack categories, an
///         axis has no usable limits, or the picture is smaller than 200 x 150 px
std::string to_svg(const Plot& plot);

}  // namespace palpate::plotting
